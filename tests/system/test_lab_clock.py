"""A laboratory whose simulated time is faster than real time: arms make the same motions, and say
that they are not in real time."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import gecos
import numpy as np
import pytest
from processes import Laboratory
from robcl.manipulator import Manipulator
from robcl.six_axis import Joints, SixAxis
from robcl.world import World

GECOS = [sys.executable, "-m", "gecos.cli"]
FAST = 20.0
OVERLOADED = 100_000.0
"""No machine makes a cycle of the control loop in 40 ns."""
CYCLE = 0.004

Course = dict[int, np.ndarray[tuple[int], np.dtype[np.float64]]]


def start(lab: Laboratory, arm: str, name: str, clock: float) -> SixAxis:
    lab.start(
        lab.build / "devices" / arm / f"robcl-{arm}",
        *("--name", name, "--clock", f"{clock:g}"),
        ready=f"{name} is ready",
    )
    return gecos.Lab().create(SixAxis, name)


def moved(robot: SixAxis) -> Course:
    """Moves all joints and returns the set points of the cycles in which they moved, each with its
    number."""
    at = np.array(robot.commanded_joints().result().position)
    goal = at - 0.3
    course: Course = {}
    with gecos.actor(robot), robot.commanded_joints.stream() as commanded:
        move = robot.move_joints(Joints(goal.tolist()))
        while move.state is gecos.State.RUNNING:
            sample = commanded.next(10.0)
            course[sample.sequence] = np.array(sample.value.position)
        move.result()
    return {
        number: joints
        for number, joints in course.items()
        if (joints != at).any() and (joints != goal).any()
    }


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("arm", ["rx90", "puma560"])
def test_a_fast_clock_changes_no_set_point(arm: str, lab_with_broker: Laboratory) -> None:
    # A busy machine may miss cycles in real time, which delays the motion, but none at half speed.
    slow = moved(start(lab_with_broker, arm, "SLOW", 0.5))
    assert len(slow) == max(slow) - min(slow) + 1, "no sample was lost"
    expected = np.array(list(slow.values()))
    robot = start(lab_with_broker, arm, "FAST", FAST)
    assert robot.clock_speed().result() == FAST
    assert robot.cycle().result() == CYCLE, "simulated time"
    start_of_move = robot.commanded_joints().result()
    # The reader gets 5000 samples a second, and may lose most of a move while it waits for a
    # processor. The others show that each set point lasted one cycle.
    for _ in range(20):
        fast = moved(robot)
        cycles = []
        for number, joints in fast.items():
            away = np.abs(expected - joints).max(axis=1)
            assert away.min() <= 1e-9, f"{joints} is no set point of the slow motion"
            cycles.append(number - away.argmin())
        assert len(set(cycles)) <= 1
        if len(fast) > len(expected) / 4:
            break
        with gecos.actor(robot):
            robot.move_joints(start_of_move).result()
    else:
        pytest.fail(f"of the last of 20 moves only {len(fast)} set points were read")
    assert robot.missed_cycles().result() == 0


@pytest.mark.usefixtures("here")
def test_an_overloaded_machine_skips_nothing_and_tells_the_speed_that_it_reaches(
    lab_with_broker: Laboratory,
) -> None:
    robot = start(lab_with_broker, "rx90", "RX90", OVERLOADED)
    moved(robot)  # the command ends as FINISHED
    assert robot.missed_cycles().result() == 0
    assert robot.clock_speed().result() == OVERLOADED
    with robot.tool.stream() as tool:
        first, began = tool.next(10.0).sequence, time.monotonic()
        told = []
        while time.monotonic() - began < 1.0:
            told.append(robot.reached_clock_speed().result())
            number = tool.next(10.0).sequence
        passed = (number - first) * CYCLE / (time.monotonic() - began)
    assert 0 < max(told) < OVERLOADED
    assert passed / 5 < np.mean(told) < passed * 5


LABORATORY = """\
[clock]
speed = 20

[programs.WORLD]
run = ["robcl-world"]

[programs.ARM]
run = ["robcl-rx90", "--name", "ARM"]

[programs.OTHER]
run = ["robcl-puma560", "--name", "OTHER", "--clock", "5"]
"""


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(("options", "speed"), [((), 20), (("--clock", "2.5"), 2.5)])
def test_a_laboratory_has_one_clock_and_says_so(
    lab: Laboratory, tmp_path: Path, options: tuple[str, ...], speed: float
) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(LABORATORY)
    up = lab.start(*GECOS, "up", "--programs", lab.build, *options, file)
    about = f"simulated time is {speed:g} times as fast as real time"
    up.wait_for(f"[WORLD] robcl-world: {about}; WORLD is ready")
    up.wait_for(f"[ARM] robcl-rx90: {about}; ARM is ready")
    up.wait_for(f"up: WORLD, ARM, OTHER are ready; {about}; Ctrl-C ends them")
    known = gecos.Lab()
    assert known.create(World, "WORLD").clock_speed().result() == speed
    assert known.create(Manipulator, "ARM").clock_speed().result() == speed
    assert known.create(Manipulator, "OTHER").clock_speed().result() == 5, "its own option"
    asked = lab.run(*GECOS, "get", "WORLD", "clock_speed")
    assert asked.finish() == 0, str(asked)
    assert asked.output() == f"{float(speed)} s/s"
