"""Straight moves of a served arm, asked for from Python."""

from __future__ import annotations

import time
from math import radians

import gecos
import pytest
from processes import Laboratory
from robcl.frames import rotate_z, translate
from robcl.manipulator import (
    Configuration,
    Elbow,
    JointLimit,
    PathType,
    Shoulder,
    Trajectory,
    Wrist,
)
from robcl.six_axis import Joints, SixAxis
from test_arm_file import ARMS, robcl_arm

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture
def robot(lab_with_broker: Laboratory) -> SixAxis:
    lab = lab_with_broker
    lab.start(robcl_arm(lab), ARMS / "rx90.toml", "--name", "RX90", ready="RX90 is ready")
    return gecos.Lab().create(SixAxis, "RX90")


def test_a_joint_limit_on_the_way_is_told_with_its_place_and_the_configuration(
    robot: SixAxis,
) -> None:
    degrees = (0, -20, 110, 0, 90, 260)  # the limit of joint 6 is 270
    with gecos.actor(robot):
        robot.move_joints(Joints([radians(angle) for angle in degrees])).result()
        start = robot.tool().result()
        goal = translate(0.0, 0.0, -0.05) * start * rotate_z(radians(20))
        with pytest.raises(
            JointLimit, match=r"place=PlaceOnLine\(way=0\.02\d*, turn=0\.1[678]"
        ) as refused:
            robot.move(goal, Trajectory(path=PathType.STRAIGHT)).result()
        robot.move(goal, Trajectory(path=PathType.JOINT)).result()
    why = refused.value
    assert why.axis == 6
    assert why.upper < why.value < why.upper + radians(1)
    assert why.place is not None
    assert why.place.way == pytest.approx(0.025, abs=1.1e-3)
    assert why.place.turn == pytest.approx(radians(10), abs=radians(0.5))
    assert why.configuration == Configuration(Shoulder.RIGHTY, Elbow.ABOVE, Wrist.FLIP)


def test_a_slow_acceleration_makes_a_straight_move_last_as_long_as_it_takes(robot: SixAxis) -> None:
    goal = robot.tool().result() * translate(0.0, 0.0, -0.1)
    how = Trajectory(path=PathType.STRAIGHT, tool_acceleration=0.1)
    with gecos.actor(robot):
        began = time.monotonic()
        robot.move(goal, how).result()
        assert time.monotonic() - began >= 2 * (0.1 / 0.1) ** 0.5  # s: half the way to speed up
        how.path = PathType.JOINT
        with pytest.raises(gecos.CommandFailed, match="limit a straight move"):
            robot.move(goal, how).result()
