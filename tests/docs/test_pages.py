"""Each page, followed to the letter in a home directory and a network of its own."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from course import LESSONS, Course
from hosts import Hosts
from pages import Reader, blocks_of
from terminals import Terminal


def test_the_simulated_laboratory(reader: Reader) -> None:
    reader.follow("docs/simulated-laboratory.md")


@pytest.mark.timeout(300)
def test_a_program_of_ones_own(reader: Reader) -> None:
    reader.follow("docs/own-program.md")
    mine = reader.terminals["2"]
    did(mine, "gecos call LDS power on=false")
    said = did(mine, "python approach.py", status=1)
    assert said[0].startswith("robcl::SensorFault("), "a failed measurement is no failed move"


@pytest.mark.timeout(300)
def test_a_server_in_cpp(reader: Reader) -> None:
    reader.follow("docs/cpp-server.md")
    mine = reader.terminals["3"]
    did(mine, f"cat > stopped.py <<'END'\n{STOPPED_WHILE_THE_BRAKE_OPENS}END")
    assert "REJECTED: the motor is off: call power_on" in did(mine, "python stopped.py")


@pytest.mark.timeout(300)
def test_sanitizers(reader: Reader) -> None:
    reader.follow("docs/sanitizers.md")


@pytest.mark.timeout(600)
@pytest.mark.parametrize("lesson", LESSONS, ids=lambda page: Path(page).name)
def test_a_lesson(lesson: str, course: Course) -> None:
    course.follow(lesson)


@pytest.mark.timeout(300)
def test_two_machines(reader: Reader, hosts: Hosts) -> None:
    hosts.without_route(1)  # of the second machine, which has no default route either
    reader.follow("docs/two-machines.md")


@pytest.mark.timeout(300)
def test_continuous_integration(reader: Reader) -> None:
    reader.follow("docs/ci.md")
    mine = reader.terminals["1"]
    did(mine, "git restore . && sed -i 's/in double target/in float target/' idl/lab/*.gidl")
    did(mine, "gidl gen && git commit -q -a -m 'Another type'")

    runner = reader.terminals["runner"] = reader.open_terminal("runner")
    did(runner, f". .venv/bin/activate; git clone -q {THERE} ~/checked-out && cd ~/checked-out")
    did(runner, "export GITHUB_ACTIONS=true BASE=origin/main BREAKING=false")
    *before, last = commands_of(workflow_of("docs/ci.md"))
    for command in before:
        if not command.startswith(("sudo ", "make ")):  # packages are there, the tree is built
            did(runner, command.replace("robcl/build", reader.build))
    said = did(runner, last, status=1)
    assert any(line.startswith("::error file=idl/lab/thermometer.gidl,line=15,") for line in said)
    did(runner, "export BREAKING=true")  # the label is "breaking"
    assert "ci: passed" in did(runner, last)


STOPPED_WHILE_THE_BRAKE_OPENS = """
import gecos
lift = gecos.dynamic("LIFT")
with gecos.actor(lift):
    power_on = lift.power_on()
    while power_on.progress().detail in (gecos.Detail.SENT, gecos.Detail.QUEUED):
        pass
    gecos.stop(lift).result()
with gecos.actor(lift):  # its first call begins when the handler of power_on has returned
    move = lift.move_to(0.05)
    move.wait()
    print(move.exception())
"""
THERE = "~/../home/projects/thermometer"
STEP = re.compile(r"^( +)run: (?:\|\n((?:\1  .*\n)+)|(.*)\n)", re.MULTILINE)


def did(at: Terminal, command: str, status: int = 0) -> list[str]:
    """What a command printed. Asserts that it ends with `status`."""
    at.type(command)
    return at.finish(status)


def workflow_of(page: str) -> str:
    (found,) = (block.text for block in blocks_of(page) if block.language == "yaml")
    return found


def commands_of(workflow: str) -> list[str]:
    """The lines that its steps run."""
    runs = [several or one for _, several, one in STEP.findall(workflow)]
    return [line.strip() for run in runs for line in run.splitlines()]


@pytest.mark.timeout(300)
@pytest.mark.usefixtures("cell")
def test_deploying(reader: Reader) -> None:
    reader.follow("docs/deploying.md")
