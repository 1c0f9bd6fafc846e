"""What a program is called by those who ask who holds a robot."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import gecos
import pytest
from gecos.program import program_name
from lamp import Burnt, Lamp
from test_process import running, says

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


TELLING = """
import os
os.environ["GECOS_LOG"] = "info"
import gecos, {module}
gecos.serve({{"LAMP": {module}.{servant}()}}, simulated=True)
"""


def told_by(server: subprocess.Popen[str]) -> list[str]:
    """Ends a server, and gives what it has logged as server. This process is called ME."""
    server.send_signal(signal.SIGTERM)
    _, err = server.communicate(timeout=30)
    assert server.returncode == 0, err
    start = "gecos info server: "
    me = rf"\S+ on \S+ \({re.escape(program_name())}, pid {os.getpid()}\)"
    lines = [line.removeprefix(start) for line in err.splitlines() if line.startswith(start)]
    return [re.sub(me, "ME", line) for line in lines]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_at_info_a_server_tells_who_called_what_and_how_it_ended(
    lab: gecos.Lab, medium: str
) -> None:
    with running(TELLING.format(module="lamp", servant="PlainLamp")) as server:
        assert says(server) == "serving LAMP\n"
        with gecos.Lab() as mine:
            lamp = mine.create(Lamp, "LAMP", medium=medium)
            with pytest.raises(gecos.CommandFailed):
                lamp.dim(2.0).result()
            with gecos.actor(lamp):
                lamp.dim(2.0).result()
                with pytest.raises(gecos.CommandFailed):
                    lamp.shine(-1.0).result()
                with pytest.raises(Burnt):
                    lamp.shine(101.0).result()
            lamp.label().result()
        told = told_by(server)
    ended = "of ME ended COMMAND_FAILED"
    expected = [
        rf"LAMP: ME connects over {medium}",
        rf"LAMP\.dim {ended}/DENIED: 'dim' of LAMP needs actor status.*",
        r"LAMP: ME has ACTOR status",
        r"LAMP\.dim of ME ended FINISHED/DONE after \S+ s",
        rf"LAMP\.shine {ended}/REJECTED after \S+ s: a lamp does not shine darkness.*",
        rf"LAMP\.shine {ended}/FAULT after \S+ s: .*Burnt.*",
        r"LAMP: ME releases its status",
        r"LAMP: ME leaves",
    ]
    assert len(told) == len(expected), "\n".join(told)
    for line, pattern in zip(told, expected, strict=True):
        assert re.fullmatch(pattern, line), "\n".join(told)


def sessions_in(told: list[str]) -> int:
    return sum(" connects over " in line for line in told)


def test_what_explain_asks_opens_no_session_with_the_object(lab: gecos.Lab) -> None:
    with running(TELLING.format(module="lamp", servant="PlainLamp")) as server:
        assert says(server) == "serving LAMP\n"
        with gecos.Lab() as asks:
            suits = {each.medium: each.suitable for each in asks.explain(Lamp, "LAMP").media}
            assert suits["shm"] and suits["lcm"]
        assert sessions_in(told_by(server)) == 0


def test_the_command_explain_reads_the_model_of_the_object_and_tries_no_medium(
    lab: gecos.Lab,
) -> None:
    with running(TELLING.format(module="shelf", servant="Shelf")) as server:
        assert says(server) == "serving LAMP\n"
        words = [sys.executable, "-m", "gecos.cli", "explain", "LAMP"]
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert "lcm" in done.stdout
        assert sessions_in(told_by(server)) == 1


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
