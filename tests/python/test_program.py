"""What a program is called by those who ask who holds a robot."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import gecos
import pytest
from gecos.program import program_name
from lamp import Lamp

SAYING = "from gecos.program import program_name\nprint(program_name())\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A script, a module and a package that say what they are called."""
    (tmp_path / "lift.py").write_text(SAYING)
    (tmp_path / "tools" / "lifter").mkdir(parents=True)
    (tmp_path / "tools" / "once.py").write_text(SAYING)
    (tmp_path / "tools" / "lifter" / "__main__.py").write_text(SAYING)
    return tmp_path


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["./lift.py", "--fast"], "lift.py"),
        (["-m", "lift"], "lift"),
        (["-m", "tools.once"], "tools.once"),
        (["-m", "tools.lifter"], "tools.lifter"),
        (["tools/lifter"], "lifter"),
        (["-c", SAYING], "python"),
    ],
)
def test_a_program_is_called_as_it_was_started(folder: Path, words: list[str], name: str) -> None:
    said = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env={"PYTHONPATH": ":".join(filter(None, sys.path))},
        capture_output=True,
        text=True,
        check=True,
    )
    assert said.stdout == f"{name}\n"


def test_python_that_reads_from_a_pipe_is_python(folder: Path) -> None:
    said = subprocess.run(
        [sys.executable],
        input=SAYING,
        env={"PYTHONPATH": ":".join(filter(None, sys.path))},
        capture_output=True,
        text=True,
        check=True,
    )
    assert said.stdout == "python\n"


def test_a_name_that_is_no_text_can_be_sent_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["__main__"], "__spec__", None)
    monkeypatch.setattr(sys, "argv", ["/opt/\udcff.py"])
    assert program_name() == "?.py"


def test_a_log_level_that_there_is_not_is_refused_by_name(place: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gecos.cli", "ls"],
        env={**os.environ, "GECOS_LOG": "loud"},
        capture_output=True,
        text=True,
    )
    said = (
        'gecos: GECOS_LOG is "loud", which is not a log level; '
        "write error, warning, info or debug\n"
    )
    assert (done.returncode, done.stderr) == (1, said)


def test_at_info_a_program_tells_what_it_connects_to_and_how_its_calls_end(
    server: gecos.Server, place: Path
) -> None:
    program = (
        "import gecos; from lamp import Lamp\n"
        "lamp = gecos.Lab().create(Lamp, 'LAMP', medium='shm')\n"
        "with gecos.actor(lamp): lamp.dim(2.0).result(); lamp.label().result()"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "GECOS_LOG": "info"},
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
    )
    lines = done.stderr.splitlines()
    assert any(line.startswith("gecos info client: connected to LAMP (test::") for line in lines)
    assert "gecos info client: LAMP.dim ended FINISHED/DONE" in lines
    assert "LAMP.label" not in done.stderr


@pytest.mark.parametrize("medium", ["inproc", "shm", "lcm"])
def test_the_holder_of_a_robot_is_named_so(
    lab: gecos.Lab, server: gecos.Server, medium: str
) -> None:
    lamp = lab.create(Lamp, "LAMP", medium=medium)
    with gecos.actor(lamp):
        (holder,) = gecos.holders(lamp).result()
        assert holder.program == program_name()
        with pytest.raises(gecos.LeaseRefused, match=rf"\({program_name()}, pid "):
            gecos.actor(lab.create(Lamp, "LAMP", medium=medium))
