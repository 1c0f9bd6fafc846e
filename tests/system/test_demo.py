"""`make demo`, and the promises around it."""

from __future__ import annotations

import signal
import sys
import uuid
from pathlib import Path

import gecos
import pytest
from processes import PATIENCE_S, Laboratory, await_ends, until
from robcl.world import World

TREE = Path(__file__).resolve().parents[2]
DEMO = TREE / "examples" / "demo.py"


def alive_with(marker: str) -> dict[int, str]:
    """Command lines of the processes that have inherited `marker` in their environment."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if marker.encode() in (process / "environ").read_bytes():
                words = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                found[int(process.name)] = words
        except OSError:
            continue  # it has ended, or is somebody else's
    return found


@pytest.mark.timeout(240)
def test_the_block_is_lifted_from_cpp_and_from_python(lab: Laboratory) -> None:
    demo = lab.start(sys.executable, DEMO, "--build", lab.build, "--clock", "10")
    assert demo.finish(200) == 0, str(demo)
    lifts = [line for line in demo.lines if "lifted by" in line and line.startswith("block:")]
    assert len(lifts) == 2, str(demo)
    assert "lift: RUNNING/EXECUTING" in demo.output()
    assert "FINISHED" in demo.output()


@pytest.mark.parametrize(
    ("number", "status"),
    [(signal.SIGINT, 130), (signal.SIGHUP, 130), (signal.SIGKILL, -signal.SIGKILL)],
)
def test_however_it_is_ended_it_leaves_nothing_running(
    lab: Laboratory, number: signal.Signals, status: int
) -> None:
    marker = f"demo-of-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    demo = lab.start(sys.executable, DEMO, "--build", lab.build)
    demo.wait_for("approach: RUNNING/EXECUTING")
    alive = alive_with(marker)
    assert len(alive) >= 7, "the demo, its five servers and the program"
    demo.signal(number)
    assert demo.finish() == status, str(demo)
    if number == signal.SIGKILL:  # nobody waits for them
        await_ends(alive | alive_with(marker))
    assert alive_with(marker) == {}


@pytest.mark.usefixtures("here", "fast_clock")
@pytest.mark.parametrize("language", ["C++", "Python"])
def test_a_program_that_ends_without_waiting_still_lifts_the_block(
    language: str, lab_with_devices: Laboratory
) -> None:
    lab = lab_with_devices
    program = {
        "C++": [lab.build / "examples" / "grip_block"],
        "Python": [sys.executable, TREE / "examples" / "02_grip_block" / "grip_block.py"],
    }[language]
    world = gecos.Lab().create(World, "WORLD")

    def height() -> float:
        return world.find("BLOCK").result().pose.z

    before = height()
    left = lab.start(*program, "--leave")
    assert left.finish(PATIENCE_S) == 0, str(left)
    assert "lift: left to the robot" in left.output()
    until(lambda: abs(height() - before - 0.2) < 1e-3, "the block is lifted")
