"""Gives mutated vectors to generated C++ (the program that is named) and generated Python, and
compares what they say: accepted and the same value again, or refused. Exits 1 where they differ.
"""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
from pathlib import Path

from gecos import wire
from type_values import TREE, cases, load, python_type

SEED = 20260117
PER_CASE = 250


def mutated(data: bytes, dice: random.Random) -> bytes:
    """One to three of: a flipped bit, another byte, a cut, more bytes, a count too large."""
    changed = bytearray(data)
    for _ in range(dice.randint(1, 3)):
        at = dice.randrange(len(changed) + 1)
        match dice.randrange(6):
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
                changed[start : start + 4] = dice.choice(
                    (
                        b"\0\0\0\0",
                        b"\0\0\0\1",
                        b"\xff\xff\xff\xff",
                        b"\x7f\xff\xff\xff",
                        b"\0\1\0\1",
                    )
                )
            case _:
                del changed[at : at + dice.randint(1, 4)]
    return bytes(changed)


def main(program: str) -> int:
    model = load()
    with tempfile.TemporaryDirectory() as folder:
        search = ["-I", str(TREE / "idl"), "-I", str(TREE / "tests" / "idl")]
        subprocess.run(
            [sys.executable, "-m", "gidl", "gen", *search, "--out", folder,
             str(TREE / "tests" / "idl" / "everything.gidl")],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        sys.path.insert(0, str(Path(folder) / "python"))
        dice = random.Random(SEED)
        asked = [
            (case.type, mutated(case.bytes, dice)) for case in cases() for _ in range(PER_CASE)
        ]
        lines = "".join(f"{kind} {data.hex()}\n" for kind, data in asked)
        answer = subprocess.run([program], input=lines, capture_output=True, text=True, check=True)
        theirs = answer.stdout.splitlines()
        assert len(theirs) == len(asked), "the C++ program ended early"

        accepted = differences = 0
        for (kind, data), line in zip(asked, theirs, strict=True):
            try:
                value = wire.from_bytes(python_type(model, kind), data)
                ours = f"accepted {wire.to_bytes(value).hex()}"
                accepted += 1
                if "nan" in repr(value):  # its payload may change on the way through a double
                    ours, line = ours.partition(" ")[0], line.partition(" ")[0]
            except wire.DecodeError as error:
                ours, line = "refused", "refused" if line.startswith("refused") else line
                reason = str(error)
            if ours.rstrip() != line.rstrip():
                differences += 1
                shown = ours if ours != "refused" else f"refused {reason}"
                print(f"{kind} {data.hex()}\n  Python: {shown}\n  C++:    {line}")
    print(f"{len(asked)} byte strings, {accepted} accepted, {differences} differences")
    return 1 if differences or not accepted else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
