"""The whole front end against text nobody would write: findings, no traceback, bounded time.

    python tests/fuzz/parser_fuzz.py --seconds 600 [--seed 7]

Pieces of the corpus are cut, doubled, mixed and bent. Exit status 0: nothing found; 1: the input is
kept as a file where the program runs, and the traceback printed.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TREE / "codegen"))
CORPUS = TREE / "tests" / "gidl"
PIECE = re.compile(r"\w+|\s+|.", re.S)
SLOWEST_SECONDS = 20.0  # of CPU, for one input of at most 64 KiB
LONGEST = 64 * 1024


def check(data: bytes, place: Path) -> None:
    """Compiles one input and everything that follows; raises whatever escapes."""
    from gidl.compile import compile_files
    from gidl.diagnostics.findings import Findings, as_json, as_text
    from gidl.omg import DIALECTS, omg_text
    from gidl.targets.model_json import model_text
    from gidl.wire import hashes, wire_layout
    from gidl.wire.events import events_as_streams

    place.write_bytes(data[:LONGEST])
    started = time.process_time()
    compiled = compile_files([str(place)], [str(TREE / "idl")])
    as_text(list(compiled.findings), compiled.sources)
    as_json(list(compiled.findings), compiled.sources)
    if not compiled.has_errors:
        model = events_as_streams(compiled.model)
        model_text(model, wire_layout.build(model), whole=True)
        for interface in compiled.model.interfaces():
            hashes.interface_hash(compiled.model, interface)
        for dialect in DIALECTS:
            omg_text(compiled.model, dialect, True, Findings())
    took = time.process_time() - started
    if took > SLOWEST_SECONDS:
        raise TimeoutError(f"{len(data)} bytes took {took:.1f} s")


def texts() -> list[str]:
    folders = (CORPUS / "good", CORPUS / "bad", CORPUS / "preprocessor", TREE / "idl")
    return [p.read_text(encoding="utf-8") for f in folders for p in sorted(f.rglob("*.gidl"))]


def bent(chance: random.Random, known: list[str], words: list[str]) -> bytes:
    """A corpus file, or two of them, after some accidents."""
    pieces = PIECE.findall(chance.choice(known))
    if chance.random() < 0.3:
        other = PIECE.findall(chance.choice(known))
        pieces = pieces[: chance.randrange(len(pieces) + 1)] + other[chance.randrange(len(other)) :]
    for _ in range(chance.randrange(1, 6)):
        at = chance.randrange(len(pieces) + 1)
        end = min(len(pieces), at + chance.randrange(1, 12))
        accident = chance.randrange(6)
        if accident == 0:
            del pieces[at:end]
        elif accident == 1:
            pieces[at:at] = pieces[at:end] * chance.randrange(1, 20)
        elif accident == 2:
            pieces[at:end] = [chance.choice(words)]
        elif accident == 3:
            pieces[at:at] = [chance.choice(words) for _ in range(chance.randrange(1, 5))]
        elif accident == 4:
            to = chance.randrange(len(pieces) + 1)
            pieces[to:to] = pieces[at:end]
        else:
            pieces[at:at] = [chr(chance.randrange(1, 0x2FF))]
    data = bytearray("".join(pieces).encode("utf-8", "replace"))
    if chance.random() < 0.05 and data:
        data[chance.randrange(len(data))] = chance.randrange(256)
    return bytes(data)


def inputs(seed: int) -> Iterator[bytes]:
    """The same ones for the same seed, without end."""
    chance = random.Random(seed)
    known = texts()
    words = sorted({piece for text in known for piece in PIECE.findall(text)})
    while True:
        yield bent(chance, known, words)


def run(seconds: float, seed: int) -> int:
    """Exit status: whether nothing was found."""
    done = 0
    until = time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "some.gidl"
        for data in inputs(seed):
            if time.monotonic() >= until:
                break
            try:
                check(data, place)
            except Exception:
                kept = Path(f"parser-{seed}-{done}.gidl")
                kept.write_bytes(data)
                traceback.print_exc()
                print(f"parser_fuzz: input {done} of seed {seed}, kept as {kept}", file=sys.stderr)
                return 1
            done += 1
    print(f"parser_fuzz: {done} inputs of seed {seed} in {seconds:g} s, no finding")
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(4)))
    chosen = parser.parse_args()
    return run(chosen.seconds, chosen.seed)


if __name__ == "__main__":
    sys.exit(main())
