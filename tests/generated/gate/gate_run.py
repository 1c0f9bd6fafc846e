"""One run of the gate over many sets of files: generated, compiled, type-checked, compared."""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
import traceback
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from random import Random

import files
from building import (
    TREE,
    Compiler,
    Generated,
    Rejected,
    Set,
    Shelf,
    generate,
    shelved,
    type_checked,
)
from comparing import Comparison
from cpp_side import Program, answer

AT_A_TIME = 120  # sets that mypy sees together


@dataclass
class Outcome:
    name: str
    accepted: int = 0
    refused: int = 0
    differences: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Compiling:
    """The compiler, and the threads that wait for it."""

    compiler: Compiler
    supported: Future[None]
    threads: ThreadPoolExecutor

    def start(self, made: Generated, shelf: Path) -> Future[tuple[Program, Path]]:
        return self.threads.submit(self.compiler.program, made, shelf, self.supported)


def main(words: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="gate", description=__doc__)
    parser.add_argument("--random", type=int, default=20, help="random sets of files")
    parser.add_argument("--seed", type=int, default=int(os.environ.get("GIDL_GATE_SEED", "1")))
    parser.add_argument("--values", type=int, default=12, help="values of each type and call")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--corpus", action="store_true", help="the corpus of the tests, too")
    parser.add_argument("--shown", type=int, default=5, help="differences of each set")
    parser.add_argument("--keep", type=Path, help="folder for the output, which then stays")
    parser.add_argument("--no-mypy", action="store_true")
    parser.add_argument("--sets", type=Path, help="sets of one file each, as JSON: see `listed`")
    parser.add_argument("files", nargs="*", type=Path, help="sets of one file each")
    asked = parser.parse_args(words)

    folder = asked.keep or Path(tempfile.mkdtemp(prefix="gidl-gate-"))
    folder.mkdir(parents=True, exist_ok=True)
    print(f"gate: seed {asked.seed}, {asked.random} random sets", flush=True)
    sets = [Set(f.stem, (f.resolve(),), (f.resolve().parent,)) for f in asked.files]
    if asked.sets:
        sets += listed(asked.sets)
    if asked.corpus:
        sets += corpus()
    for seed in range(asked.seed, asked.seed + asked.random):
        sets.append(random_set(folder, seed))

    failed = accepted = refused = 0
    compiler = Compiler(folder)
    compiler.first()
    with ThreadPoolExecutor(asked.jobs) as threads:
        supported = threads.submit(compiler.support)  # first: the programs wait for it
        for start in range(0, len(sets), AT_A_TIME):
            part = sets[start : start + AT_A_TIME]
            compiling = Compiling(compiler, supported, threads)
            out = folder / f"part{start}"
            for outcome in run(compiling, part, out, asked.values, asked.jobs, not asked.no_mypy):
                accepted += outcome.accepted
                refused += outcome.refused
                if outcome.differences:
                    failed += 1
                    print(f"──── {outcome.name}: {len(outcome.differences)} differences")
                    for text in outcome.differences[: asked.shown]:
                        print(text)
    if compiler.refused_by_clang_alone:
        print(f"gate: only g++ compiles {', '.join(compiler.refused_by_clang_alone)}")
    print(
        f"gate: {len(sets)} sets, {accepted} values accepted and {refused} refused by all,"
        f" {failed} sets differ"
    )
    if failed:
        print(f"gate: the output is in {folder}")
    elif asked.keep is None:
        shutil.rmtree(folder)
    return 1 if failed or not accepted or not refused else 0


def corpus() -> list[Set]:
    """Every accepted file of the tests that the gate can compare: without classes that somebody
    would have to write by hand."""
    gidl = TREE / "tests" / "gidl"
    idl = TREE / "tests" / "idl"
    found = [
        *(gidl / "good").glob("*.gidl"),
        *(gidl / "preprocessor").glob("*.gidl"),
        *idl.rglob("*.gidl"),
        *(TREE / "idl" / "robcl").glob("*.gidl"),
    ]
    return [
        Set("_".join(f.relative_to(TREE).with_suffix("").parts), (f,), (idl, f.parent))
        for f in sorted(found)
        if "own::Point" not in f.read_text(errors="replace")
    ]


def random_set(folder: Path, seed: int) -> Set:
    source = folder / "idl" / f"s{seed}"
    source.mkdir(parents=True, exist_ok=True)
    return Set(f"s{seed}", tuple(files.write(source, f"s{seed}", seed)), (source,))


def listed(file: Path) -> list[Set]:
    """Sets from a file that `tests/fuzz/public_idl.py --accepted` writes: a list of objects with
    `name`, `file`, `search` (folders), `wide` and `defines`."""
    return [
        Set(
            one["name"],
            (Path(one["file"]),),
            tuple(map(Path, one["search"])),
            one["wide"],
            tuple(one["defines"]),
        )
        for one in json.loads(file.read_text(encoding="utf-8"))
    ]


def run(
    compiling: Compiling, sets: list[Set], out: Path, values: int, jobs: int, mypy: bool
) -> list[Outcome]:
    outcomes = {each.name: Outcome(each.name) for each in sets}
    made: list[Generated] = []
    for each in sets:
        try:
            made.append(generate(each))
        except Rejected as why:
            outcomes[each.name].differences.append(f"not generated: {why}")
        except Exception:
            outcomes[each.name].differences.append(f"gidl failed: {traceback.format_exc()}")
    checked = Outcome("mypy")
    for shelf in shelved(made, out):
        types = compiling.threads.submit(type_checked, shelf.folder) if mypy else None
        _judge(compiling, shelf, outcomes, values, jobs)
        if types is not None and types.result():
            checked.differences.append(types.result())
    return [*outcomes.values(), checked]


def _judge(
    compiling: Compiling, shelf: Shelf, outcomes: dict[str, Outcome], values: int, jobs: int
) -> None:
    """Compiles and compares the sets of a shelf."""
    with ProcessPoolExecutor(jobs, get_context("spawn")) as processes:  # threads run beside
        compiled = [(each, compiling.start(each, shelf.folder)) for each in shelf.sets]
        compared = []
        for one, future in compiled:
            try:
                program, binary = future.result()
            except Rejected as why:
                outcomes[one.set.name].differences.append(str(why))
                continue
            except Exception:
                outcomes[one.set.name].differences.append(traceback.format_exc())
                continue
            told = processes.submit(compare, shelf.folder, one, program, binary, values)
            compared.append((one, told))
        for one, told in compared:
            outcome = told.result()
            outcome.differences = outcomes[one.set.name].differences + outcome.differences
            outcomes[one.set.name] = outcome


def compare(folder: Path, made: Generated, program: object, binary: Path, values: int) -> Outcome:
    """In a process of its own, because generated modules are imported."""
    sys.path.insert(0, str(folder / "python"))
    outcome = Outcome(made.set.name)
    try:
        dice = Random(made.set.name)
        comparison = Comparison(made.model, made.layout, program, dice)  # type: ignore[arg-type]
        questions = comparison.prepare(values)
        outcome.differences += answer(program, binary, questions)  # type: ignore[arg-type]
        comparison.judge()
        outcome.differences += comparison.differences
        outcome.accepted, outcome.refused = comparison.accepted, comparison.refused
    except Exception:
        outcome.differences.append(traceback.format_exc())
    return outcome
