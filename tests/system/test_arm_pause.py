"""An arm whose server stands still in the middle of a motion."""

from __future__ import annotations

import signal
import time

import gecos
import numpy as np
import pytest
from processes import Laboratory, until
from robcl.frames import Frame, distance, translate
from robcl.manipulator import Manipulator, PathType, Trajectory
from test_arm_file import ARMS, robcl_arm

pytestmark = pytest.mark.usefixtures("here")

PAUSE_S = 2.0
SPEED = 0.05  # of the tool, m/s


def last_of(tool: gecos.Stream[Frame], pose: Frame) -> Frame:
    """Returns the last pose that the server has sent before it stood still; `pose` if none."""
    try:
        while True:
            pose = tool.next(0.1).value
    except TimeoutError:
        return pose


def test_after_a_long_pause_the_arm_brakes_and_does_not_go_on(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    server = lab.start(robcl_arm(lab), ARMS / "rx90.toml", "--name", "RX90", ready="RX90 is ready")
    robot = gecos.Lab().create(Manipulator, "RX90")
    start = robot.tool().result()
    how = Trajectory(path=PathType.STRAIGHT, tool_speed=SPEED)
    tool = robot.tool.stream()
    with gecos.actor(robot):
        move = robot.move(start * translate(0.0, 0.3, 0.0), how)
        pose = start
        while distance(start, pose) < 0.02:
            pose = tool.next(1).value
        server.signal(signal.SIGSTOP)
        before = last_of(tool, pose)
        time.sleep(PAUSE_S)
        server.signal(signal.SIGCONT)
        with pytest.raises(gecos.CommandFailed, match=r"silent|stood still"):
            move.result()
    robot = gecos.Lab().create(Manipulator, "RX90", wait=10.0)  # the name was free meanwhile
    until(lambda: robot.standing().result(), "the arm stands")
    stood, tool = robot.tool().result(), robot.tool.stream()
    assert distance(before, stood) < 0.1 * SPEED, "it brakes at once"
    assert robot.missed_cycles().result() > 0
    places = np.array([tool.next(1).value.position for _ in range(250)])  # m, of a second
    assert np.linalg.norm(places - stood.position, axis=1).max() < 1e-4, "nothing goes on"
    with gecos.actor(robot):
        robot.move(start).result()
