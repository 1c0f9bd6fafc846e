"""`gecos plot` records and draws what simulated arms do."""

from __future__ import annotations

import json
import re
import signal
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from gecos.cli.plot.limits import read_limits
from gecos.cli.plot.motion import magnitude, of_joints, of_tool
from gecos.cli.plot.recording import read_csv
from processes import Laboratory, Program

TREE = Path(__file__).resolve().parents[2]
ARMS = TREE / "devices" / "arms"
GECOS = [sys.executable, "-m", "gecos.cli"]
ROUND_CORNERS = TREE / "examples" / "18_round_corners" / "round_corners.py"
MOVE_TOOL = Path(__file__).parent / "programs" / "move_tool.py"
TO_AND_FRO = """
import gecos
from robcl.frames import mm, translate
from robcl.manipulator import Manipulator, Trajectory
robot = gecos.Lab().create(Manipulator, "RX90")
start = robot.tool().result()
with gecos.actor(robot):
    while True:
        for at in (100, 0):
            robot.move(start * translate(0.0, 0.0, mm(-at)), Trajectory(speed=0.05)).result()
"""


def plotting(lab: Laboratory, *words: str | Path) -> Program:
    """`gecos plot`, which waits until the arm moves."""
    return lab.start(*GECOS, "plot", *words, ready="waits until")


def test_a_motion_with_rounded_corners_is_drawn_with_its_limits(
    lab_with_arm: Laboratory, tmp_path: Path
) -> None:
    limits = ("--limits", ARMS / "rx90.toml")
    picture, table = tmp_path / "corners.svg", tmp_path / "corners.csv"
    plot = plotting(lab_with_arm, "RX90", *limits, "-o", picture, "--csv", table, "--json")
    assert lab_with_arm.run(sys.executable, ROUND_CORNERS).finish() == 0
    assert plot.finish() == 0, str(plot)

    told = json.loads(plot.lines[-1])
    recorded = read_csv(table)
    assert told["samples"] == len(recorded) > 500
    assert told["lost"].keys() == {"tool", "joints", "commanded_joints"}
    assert sum(told["lost"].values()) < 0.05 * len(recorded), told

    arm, joints = read_limits(ARMS / "rx90.toml"), of_joints(recorded)
    assert joints is not None and arm.acceleration is not None
    assert (np.abs(joints.speed.value) <= 1.001 * arm.speed).all()
    assert (np.abs(joints.acceleration.value) <= 1.001 * arm.acceleration).all()
    tool = of_tool(recorded)
    # Where a cycle is late, the next one follows early, and the measured speed has a peak.
    assert np.quantile(magnitude(tool.speed).value, 0.95) == pytest.approx(0.25, rel=0.05)
    lower, upper = recorded.tool.min(axis=0), recorded.tool.max(axis=0)
    assert upper - lower == pytest.approx([0, 0.1, 0.1], abs=1e-3)

    texts = "".join(ElementTree.parse(picture).getroot().itertext())
    for label in (
        "RX90 (robcl::Rx90)",
        "commanded joints, °",
        "joint speed, % of its limit",
        "joint acceleration, % of its limit",
        "tool speed, m/s (measured)",
        "tool acceleration, m/s² (measured)",
        "path of the tool, front view",
    ):
        assert label in texts, label
    assert picture.stat().st_size < 150_000

    again = tmp_path / "again.svg"
    drawn = lab_with_arm.run(*GECOS, "plot", "--from", table, *limits, "-o", again)
    assert drawn.finish() == 0, str(drawn)
    assert "joint acceleration, % of its limit" in again.read_text()


def test_an_arm_of_seven_joints_is_drawn_with_its_joints(
    lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    lab = lab_with_broker
    lab.start(lab.build / "devices" / "arm" / "robcl-arm", ARMS / "iiwa14.toml", ready="ready")
    table, limits = tmp_path / "arm.csv", ("--limits", ARMS / "iiwa14.toml")
    plot = plotting(lab, "IIWA14", "-o", tmp_path / "arm.svg", "--csv", table, *limits)
    assert lab.run(sys.executable, MOVE_TOOL, "IIWA14").finish() == 0
    assert plot.finish() == 0, str(plot)
    assert "commanded joints, °" in (tmp_path / "arm.svg").read_text()
    joints = of_joints(read_csv(table))
    assert joints is not None
    assert joints.speed.value.shape[1] == 7
    assert (np.abs(joints.speed.value) <= 1.001 * read_limits(ARMS / "iiwa14.toml").speed).all()


def test_a_motion_that_is_faster_than_real_time_is_drawn_in_simulated_time(
    lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    lab, table = lab_with_broker, tmp_path / "motion.csv"
    lab.start(lab.build / "devices/rx90/robcl-rx90", "--clock", "5", ready="ready")
    plot = plotting(lab, "RX90", "--csv", table)
    assert lab.run(sys.executable, MOVE_TOOL, "RX90").finish() == 0
    assert plot.finish() == 0, str(plot)
    recorded, arm = read_csv(table), read_limits(ARMS / "rx90.toml")
    joints = of_joints(recorded)
    assert joints is not None and arm.acceleration is not None
    for course, limit in ((joints.speed, arm.speed), (joints.acceleration, arm.acceleration)):
        share = np.abs(course.value) / limit
        assert 0.3 < share.max() <= 1.001


def test_ctrl_c_draws_what_was_recorded(lab_with_arm: Laboratory, tmp_path: Path) -> None:
    table = tmp_path / "motion.csv"
    plot = plotting(lab_with_arm, "RX90", "--csv", table)
    lab_with_arm.start(sys.executable, "-c", TO_AND_FRO)
    plot.wait_for("records RX90")
    plot.signal(signal.SIGINT)
    assert plot.finish() == 0, str(plot)
    assert len(read_csv(table)) > 10
    assert not list(tmp_path.glob("*.svg")), "a table alone was asked for"


def test_a_duration_ends_a_motion_that_goes_on(lab_with_arm: Laboratory, tmp_path: Path) -> None:
    table = tmp_path / "motion.csv"
    plot = plotting(lab_with_arm, "RX90", "--csv", table, "--seconds", "0.5")
    lab_with_arm.start(sys.executable, "-c", TO_AND_FRO)
    assert plot.finish() == 0, str(plot)
    assert read_csv(table).stamp[-1] == pytest.approx(0.6, abs=0.05)


def test_a_server_that_is_killed_leaves_what_was_recorded(
    lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    lab, table = lab_with_broker, tmp_path / "motion.csv"
    arm = lab.start(lab.build / "devices" / "rx90" / "robcl-rx90", ready="ready")
    plot = plotting(lab, "RX90", "--csv", table)
    lab.start(sys.executable, "-c", TO_AND_FRO)
    plot.wait_for("records RX90")
    arm.kill()
    assert plot.finish() in (3, 4), str(plot)
    assert re.search(r"motion\.csv: RX90, .* samples", plot.output()), str(plot)
    assert len(read_csv(table)) > 10


def test_an_arm_that_does_not_move_ends_the_wait(lab_with_arm: Laboratory, tmp_path: Path) -> None:
    picture = tmp_path / "motion.svg"
    plot = lab_with_arm.run(*GECOS, "plot", "RX90", "-o", picture, "--wait", "0.2")
    assert plot.finish() == 3, str(plot)
    assert "RX90 has not moved within 0.2 s; start the motion in another terminal" in plot.output()
    assert not picture.exists()


def test_an_object_that_is_no_arm_is_refused(lab_with_broker: Laboratory, tmp_path: Path) -> None:
    lab = lab_with_broker
    lab.start(lab.build / "devices" / "gripper" / "robcl-gripper", "--carrier", "", ready="ready")
    plot = lab.run(*GECOS, "plot", "GRIPPER", "-o", tmp_path / "gripper.svg")
    assert plot.finish() == 2, str(plot)
    assert "GRIPPER (robcl::Gripper) is not an arm, so it has no motion to draw" in plot.output()
    assert "gecos ls --interface robcl::Manipulator" in plot.output()
