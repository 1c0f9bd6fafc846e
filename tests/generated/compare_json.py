"""Gives values and texts to generated C++ (the program that is named) and generated Python, and
compares what JSON they make of a value, and what they take JSON for: the same bytes, or refused at
the same place. The texts are those of json_cases.py, and random changes of what was written.
Exits 1 where they differ.

    compare_json.py <program> [--texts 6000] [--seed 20260117]
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gecos import wire
from gecos.wire.json import dumps, loads
from gidl.model import Model
from json_cases import BOTH_REFUSE, REFUSED, WRITTEN
from type_values import TREE, Case, cases, load, python_type

ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 1.0, 0.1, -0.0, 1e300, 255, 256, -129, 65_536, 2**31, 2**32, 2**63,
    -(2**63), 2**63 - 1, 2**64 - 1, 2**64, 2**70, -(2**64), "", "x", "é", "Ā", "a\0b", "nan", "inf",
    "-inf", "***", "RED", "LEFT", [], {}, [[]], [1], [1, 2], {"tag": 1}, ["RED"], [["a", 1]],
)  # fmt: skip


def places(data: Any) -> Iterator[tuple[Any, Any]]:
    """Every container inside with a key of it."""
    keys = data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
    for key in list(keys):
        yield data, key
        yield from places(data[key])


def changed(data: Any, dice: random.Random) -> Any:
    """One member or element replaced, left out, doubled or added."""
    whole = [copy.deepcopy(data)]
    around, key = dice.choice(list(places(whole)))
    match dice.randrange(8):
        case 0:
            del around[key]
        case 1 if isinstance(around, list):
            around.insert(key, copy.deepcopy(around[key]))
        case 2 if isinstance(around[key], dict):
            around[key][dice.choice(("tag", "value", "new", "first"))] = dice.choice(ODD)
        case 3 if isinstance(around[key], list):
            around[key].append(dice.choice(ODD))
        case 4:
            around[key] = copy.deepcopy(dice.choice(list(places(whole)))[0])
        case _:
            around[key] = dice.choice(ODD)
    return whole[0] if whole else None


def texts(dice: random.Random, count: int, model: Model) -> Iterator[tuple[str, str]]:
    """Types and JSON on one line."""
    for kind, text, *_ in (*WRITTEN, *REFUSED, *BOTH_REFUSE):
        yield f"everything::{kind}", text
    written = [(each.type, json.loads(python_text(model, each))) for each in cases()]
    for kind, data in written:
        yield kind, json.dumps(data)
    for i in range(count):
        kind, data = written[i % len(written)]
        yield kind, json.dumps(changed(data, dice), ensure_ascii=dice.random() < 0.5)


def python_text(model: Model, case: Case) -> str:
    return dumps(wire.from_bytes(python_type(model, case.type), case.bytes))


def python_verdict(model: Model, kind: str, text: str) -> str:
    try:
        of_type = python_type(model, kind)
        value = wire.from_bytes(of_type, wire.to_bytes(loads(of_type, text)))
    except wire.JsonError as error:
        return "refused " + ("not JSON" if error.why.startswith("not JSON") else error.path)
    return f"accepted -{wire.to_bytes(value).hex()} {json.loads(dumps(value))}"


def cpp_verdict(line: str) -> str:
    """As Python says it: where, and not in which words."""
    word, _, rest = line.partition(" ")
    if word == "accepted":
        data, _, text = rest.partition(" ")
        return f"accepted {data} {json.loads(text)}"
    if rest.startswith("not JSON"):
        return "refused not JSON"
    where, colon, _ = rest.partition(": ")
    return "refused " + (where if colon and " " not in where else "")


def answers(program: str, lines: list[str]) -> list[str]:
    done = subprocess.run(
        [program], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True
    )
    found = done.stdout.split("\n")[:-1]
    assert len(found) == len(lines), "the C++ program ended early"
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description="the same JSON for both languages")
    parser.add_argument("program", help="json_verdicts, as CMake built it")
    parser.add_argument("--texts", type=int, default=6_000, help="changed texts")
    parser.add_argument("--seed", type=int, default=20260117)
    asked = parser.parse_args()
    model = load()
    with tempfile.TemporaryDirectory() as folder:
        search = ["-I", str(TREE / "idl"), "-I", str(TREE / "tests" / "idl")]
        subprocess.run(
            [sys.executable, "-m", "gidl", "gen", *search, "--lang", "python", "--out", folder,
             str(TREE / "tests" / "idl" / "everything.gidl")],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        sys.path.insert(0, str(Path(folder) / "python"))
        return compare(asked, model)


def compare(asked: argparse.Namespace, model: Model) -> int:
    differences = accepted = 0
    known = cases()
    theirs = answers(asked.program, [f"{c.type} bytes {c.bytes.hex() or '-'}" for c in known])
    for case, line in zip(known, theirs, strict=True):
        ours = python_text(model, case)
        if json.loads(ours) != json.loads(line):
            differences += 1
            print(f"{case.id}\n  Python: {ours}\n  C++:    {line}")
    given = list(texts(random.Random(asked.seed), asked.texts, model))
    theirs = answers(asked.program, [f"{kind} json {text}" for kind, text in given])
    for (kind, text), line in zip(given, theirs, strict=True):
        our_verdict = python_verdict(model, kind, text)
        accepted += our_verdict.startswith("accepted")
        if our_verdict != cpp_verdict(line):
            differences += 1
            print(f"{kind} {text}\n  Python: {our_verdict}\n  C++:    {line}")
    print(f"{len(known)} values, {len(given)} texts, {accepted} taken, {differences} differences")
    return 1 if differences or not accepted else 0


if __name__ == "__main__":
    sys.exit(main())
