"""What a type checker says about programs: right ones pass, wrong ones are found."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]

PROGRAM = """
import asyncio
import gecos
from lamp import Glow, Lamp, PlainLamp

def use(lab: gecos.Lab) -> float:
    lamp = lab.create(Lamp, ["LAMP", "TORCH"], medium="shm")
    with gecos.actor(lamp):
        shining = lamp.shine(3.0)
        glow: Glow | None = shining.feedback()
        shining.result()
        plain: gecos.Command[float] = lamp.dim(2.0)
        reveal_type(plain.feedback())
    for sample in lamp.level.stream():
        value: float = sample.value
        return value
    return plain.result()

async def wait(lamp: Lamp) -> str:
    async for sample in lamp.level.stream():
        print(sample.value, sample.lost)
    return await lamp.label()
"""


def check(program: str, folder: Path) -> str:
    file = folder / "program.py"
    file.write_text(program, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml",
         "--cache-dir", str(folder / "cache"), str(file)],
        cwd=TREE, capture_output=True, text=True, check=False,
        env={"MYPYPATH": str(TREE / "tests/python"), "PATH": ""},
    )  # fmt: skip
    return done.stdout + done.stderr


def test_a_program_is_typed_from_end_to_end(tmp_path: Path) -> None:
    said = check(PROGRAM, tmp_path)
    assert 'Revealed type is "None"' in said
    assert "Success" in said, said


def test_wrong_programs_are_found(tmp_path: Path) -> None:
    wrong = PROGRAM + (
        "\n\ndef wrong(lamp: Lamp) -> None:\n"
        '    lamp.shine("bright")\n'
        "    result: str = lamp.dim(2.0).result()\n"
        "    lamp.level.stream().next().value.upper()\n"
    )
    said = check(wrong, tmp_path)
    assert 'Argument 1 to "shine" of "Lamp" has incompatible type "str"' in said
    assert "Incompatible types in assignment" in said
    assert '"float" has no attribute "upper"' in said
    assert "Found 3 errors" in said, said
