"""What a type checker says about programs: right ones pass, wrong ones are found."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]

PROGRAM = """
import asyncio
from dataclasses import dataclass
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

@dataclass(slots=True, eq=False)
class Cold(gecos.DeclaredError):  # as gidl writes an exception without members
    pass

def refuse() -> None:
    raise Cold()

def find(lab: gecos.Lab) -> str:
    found = gecos.Reconnecting(lab, Lamp, "LAMP")
    with gecos.ReconnectingStream(lab, Lamp, "LAMP", lambda lamp: lamp.level.stream()) as levels:
        value: float = levels.next(1.0).value
        lamp: Lamp | None = levels.proxy
        print(value, lamp)
    return found.call(lambda there: there.label().result())

async def wait(lamp: Lamp) -> str:
    async for sample in lamp.level.stream():
        print(sample.value, sample.lost)
    return await lamp.label()
"""


WRONG = """
import gecos
from lamp import Lamp

def wrong(lamp: Lamp, found: gecos.Reconnecting[Lamp]) -> None:
    lamp.shine("bright")
    result: str = lamp.dim(2.0).result()
    lamp.level.stream().next().value.upper()
    found.get().shine("bright")
"""


@pytest.fixture(scope="module")
def findings(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What one run of mypy says about both programs, a finding per line."""
    folder = tmp_path_factory.mktemp("typing")
    (folder / "right.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "wrong.py").write_text(WRONG, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml",
         "--cache-dir", str(folder / "cache"), str(folder / "right.py"), str(folder / "wrong.py")],
        cwd=TREE, capture_output=True, text=True, check=False,
        env={**os.environ, "MYPYPATH": str(TREE / "tests/python")},
    )  # fmt: skip
    return (done.stdout + done.stderr).splitlines()


def test_a_program_is_typed_from_end_to_end(findings: list[str]) -> None:
    (said,) = (line for line in findings if "right.py" in line)
    assert said.endswith('note: Revealed type is "None"')


def test_wrong_programs_are_found(findings: list[str]) -> None:
    said = [line.split(": error: ")[1] for line in findings if "wrong.py" in line]
    assert said == [
        'Argument 1 to "shine" of "Lamp" has incompatible type "str"; expected "float"  [arg-type]',
        'Incompatible types in assignment (expression has type "float", variable has type "str")  '
        "[assignment]",
        '"float" has no attribute "upper"  [attr-defined]',
        'Argument 1 to "shine" of "Lamp" has incompatible type "str"; expected "float"  [arg-type]',
    ]


def test_nothing_else_is_found(findings: list[str]) -> None:
    ours = [line for line in findings if "right.py" not in line and "wrong.py" not in line]
    assert ours == ["Found 4 errors in 1 file (checked 2 source files)"]
