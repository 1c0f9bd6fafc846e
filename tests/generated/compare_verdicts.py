"""Gives mutated vectors to generated C++ (the program that is named) and generated Python, and
compares what they say: accepted and the same value again, or refused. The program also says where
decoding took more memory than it may. Exits 1 where they differ.

    compare_verdicts.py <program> [--strings 15000] [--seed 20260117]
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from gecos import wire
from gidl.model import Model
from type_values import TREE, cases, load, python_type

COUNTS = tuple(
    number.to_bytes(4, "big", signed=True)
    for number in (0, 1, 2, 16, 17, 65_536, 65_537, -1, 2**31 - 1, -(2**31))
)
AT_A_TIME = 5_000
INFLATED_EVERY = 60  # byte strings; these are long, so that the bound on memory says something


def mutated(data: bytes, other: bytes, dice: random.Random) -> bytes:
    """One to three of: a flipped bit, another byte, a cut, more or fewer bytes, another count, a
    part of `other`, which is a valid encoding, too."""
    changed = bytearray(data)
    for _ in range(dice.randint(1, 3)):
        at = dice.randrange(len(changed) + 1)
        match dice.randrange(9):
            case 0 if at < len(changed):
                changed[at] ^= 1 << dice.randrange(8)
            case 1 if at < len(changed):
                changed[at] = dice.choice((0, 1, 2, 127, 128, 255))
            case 2:
                del changed[at:]
            case 3:
                changed[at:at] = dice.randbytes(dice.randint(1, 8))
            case 4:
                start = at & ~3
                changed[start : start + 4] = dice.choice(COUNTS)
            case 5:
                changed[at : at + 4] = dice.choice(COUNTS)
            case 6:
                changed[at:] = other[dice.randrange(len(other) + 1) :]
            case 7:
                start = dice.randrange(len(other) + 1)
                changed[at:at] = other[start : start + dice.randint(1, 32)]
            case _:
                del changed[at : at + dice.randint(1, 4)]
    return bytes(changed)


def inflated(data: bytes, dice: random.Random) -> bytes:
    """A large count where one may be, and enough bytes behind it that it can be believed."""
    places = [at for at in range(len(data) - 3) if data[at : at + 3] == b"\0\0\0"] or [0]
    at = dice.choice(places)
    filler = dice.choice((b"\0", data[at + 4 :] or b"\0", b"\0\0\0\1\0"))
    filler *= dice.randint(70_000, 120_000) // len(filler)
    width = dice.choice((1, 4, 5, 8, 9, 26))
    return data[:at] + (len(filler) // width).to_bytes(4, "big") + filler


def hostile(dice: random.Random, strings: int) -> Iterator[tuple[str, bytes]]:
    known = cases()
    for i in range(strings):
        case = known[i % len(known)]
        if i % INFLATED_EVERY == 0:
            case = dice.choice(known)
            yield case.type, inflated(case.bytes, dice)
        else:
            yield case.type, mutated(case.bytes, dice.choice(known).bytes, dice)


def python_verdict(model: Model, kind: str, data: bytes) -> tuple[str, bool]:
    """What Python says, and whether a NaN is in it: that may change on the way through a double."""
    try:
        value = wire.from_bytes(python_type(model, kind), data)
    except wire.DecodeError as error:
        return f"refused {error}", False
    return f"accepted {wire.to_bytes(value).hex()}".rstrip(), "nan" in repr(value)


def main() -> int:
    parser = argparse.ArgumentParser(description="the same bytes for both decoders")
    parser.add_argument("program", help="generated_verdicts, as CMake built it")
    parser.add_argument("--strings", type=int, default=15_000, help="byte strings in all")
    parser.add_argument("--seed", type=int, default=20260117)
    asked = parser.parse_args()
    model = load()
    with tempfile.TemporaryDirectory() as folder:
        search = ["-I", str(TREE / "idl"), "-I", str(TREE / "tests" / "idl")]
        subprocess.run(
            [sys.executable, "-m", "gidl", "gen", *search, "--out", folder,
             str(TREE / "tests" / "idl" / "everything.gidl")],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        sys.path.insert(0, str(Path(folder) / "python"))
        dice = random.Random(asked.seed)
        accepted = differences = done = 0
        while done < asked.strings:
            some = list(hostile(dice, min(AT_A_TIME, asked.strings - done)))
            done += len(some)
            lines = "".join(f"{kind} {data.hex()}\n" for kind, data in some)
            answer = subprocess.run(
                [asked.program], input=lines, capture_output=True, text=True, check=True
            )
            theirs = answer.stdout.splitlines()
            assert len(theirs) == len(some), "the C++ program ended early"
            for (kind, data), line in zip(some, theirs, strict=True):
                ours, holds_nan = python_verdict(model, kind, data)
                accepted += ours.startswith("accepted")
                # Where bytes are wrong in two ways, either may be reported.
                alike = "refused" if ours.startswith("refused") else ours
                line_alike = "refused" if line.startswith("refused") else line.rstrip()
                if holds_nan:
                    alike, line_alike = alike.partition(" ")[0], line_alike.partition(" ")[0]
                if alike != line_alike:
                    differences += 1
                    print(f"{kind} {data.hex()}\n  Python: {ours}\n  C++:    {line}")
    print(f"{done} byte strings, {accepted} accepted, {differences} differences")
    return 1 if differences or not accepted else 0


if __name__ == "__main__":
    sys.exit(main())
