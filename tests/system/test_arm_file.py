"""Arms that are two files: robcl-arm serves them, and a program that knows Manipulator alone moves
them."""

from __future__ import annotations

import re
import sys
from math import radians
from pathlib import Path

import gecos
import pytest
from processes import Laboratory, until
from robcl.articulated_arm import ArticulatedArm, JointPositions
from robcl.frames import Frame, distance
from robcl.manipulator import JointLimit, Manipulator, Trajectory

TREE = Path(__file__).resolve().parents[2]
ARMS = TREE / "devices" / "arms"
MOVE_TOOL = Path(__file__).parent / "programs" / "move_tool.py"

FIVE_JOINTS = """\
<robot name="five">
  <link name="foot"/>
  <link name="a"/>
  <link name="b"/>
  <link name="c"/>
  <link name="d"/>
  <link name="e"/>
  {joints}
</robot>
"""
JOINT = """
  <joint name="{child}" type="revolute">
    <parent link="{parent}"/> <child link="{child}"/>
    <origin xyz="0 0 0.3"/>
    <axis xyz="{axis}"/>
    <limit lower="-2.5" upper="2.5" velocity="2" effort="0"/>
  </joint>"""
FIVE_TOML = """\
name = "FIVE"
description = "arm of five joints"
urdf = "models/five.urdf"
base_link = "foot"
flange_link = "e"
seconds_to_full_speed = [0.2, 0.2, 0.2, 0.1, 0.1]
start_deg = [0, 20, 60, 60, 0]
place = "the arm of five joints stands in a test"

[tool]
offset_mm = [0, 0, 100]
speed_m_per_s = 0.5
acceleration_m_per_s2 = 2
turn_speed_deg_per_s = 90
turn_acceleration_deg_per_s2 = 360
"""


def robcl_arm(lab: Laboratory) -> Path:
    return lab.build / "devices" / "arm" / "robcl-arm"


@pytest.fixture
def own_arm(tmp_path: Path) -> Path:
    """The TOML file of an arm of five joints, in a folder that has nothing to do with the tree."""
    pairs = zip(("foot", "a", "b", "c", "d"), ("a", "b", "c", "d", "e"), strict=True)
    axes = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1")
    joints = "".join(
        JOINT.format(parent=parent, child=child, axis=axis)
        for (parent, child), axis in zip(pairs, axes, strict=True)
    )
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "five.urdf").write_text(FIVE_JOINTS.format(joints=joints))
    file = tmp_path / "five.toml"
    file.write_text(FIVE_TOML)
    return file


@pytest.mark.usefixtures("here", "fast_clock")
def test_one_program_moves_arms_of_six_and_of_seven_joints(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(robcl_arm(lab), ARMS / "iiwa14.toml", ready="IIWA14 is ready")
    lab.start(robcl_arm(lab), ARMS / "rx90l.toml", ready="RX90L is ready")
    lab.start(lab.build / "devices/rx90/robcl-rx90", ready="RX90 is ready")
    lab.start(lab.build / "devices/puma560/robcl-puma560", ready="PUMA is ready")
    found = gecos.Lab().objects(Manipulator)
    assert {entry.name: entry.interface_name for entry in found} == {
        "IIWA14": "robcl::ArticulatedArm",
        "PUMA": "robcl::Puma560",
        "RX90": "robcl::Rx90",
        "RX90L": "robcl::SixAxis",
    }
    for name in ("IIWA14", "PUMA", "RX90", "RX90L"):
        moved = lab.run(sys.executable, MOVE_TOOL, name)
        assert moved.finish() == 0, str(moved)
        assert moved.lines == ["0 mm from the goal"] * 4, str(moved)


@pytest.mark.usefixtures("here", "fast_clock")
def test_two_files_outside_the_tree_are_an_arm(lab_with_broker: Laboratory, own_arm: Path) -> None:
    lab = lab_with_broker
    lab.start(robcl_arm(lab), own_arm, ready="FIVE is ready")
    robot = gecos.Lab().create(Manipulator, "FIVE")
    with gecos.actor(robot):
        goal = Frame.from_euler_zyz(0.0, 0.0, 0.0, radians(40), 0.0, 0.0) * robot.tool().result()
        robot.move(goal).result()
        assert distance(robot.tool().result(), goal) < 1e-3
        with pytest.raises(gecos.CommandFailed, match="the arm of five joints stands in a test"):
            robot.mount("RX90", Frame()).result()


@pytest.mark.usefixtures("here")
def test_the_joints_of_an_arm_of_five_and_of_seven_are_moved_and_read(
    lab_with_broker: Laboratory, own_arm: Path
) -> None:
    lab = lab_with_broker
    lab.start(robcl_arm(lab), own_arm, ready="FIVE is ready")
    joints_move("FIVE", [0, 20, 60, 60, 0])
    lab.start(robcl_arm(lab), ARMS / "iiwa14.toml", ready="IIWA14 is ready")
    joints_move("IIWA14", [0, 20, 0, -90, 0, 70, 0])


def joints_move(name: str, start_deg: list[float]) -> None:
    robot = gecos.Lab().create(ArticulatedArm, name)
    start = [radians(angle) for angle in start_deg]
    assert list(robot.joints().result().position) == pytest.approx(start, abs=1e-3)
    target = [position - 0.1 for position in start]
    with gecos.actor(robot), robot.commanded_joints.stream() as commanded:
        robot.move_joints(JointPositions(target), Trajectory(speed=0.5)).result()
        assert list(robot.joints().result().position) == pytest.approx(target, abs=1e-3)
        last = pytest.approx(target, abs=1e-9)
        until(lambda: list(commanded.next(1).value.position) == last, "the last set point comes")
        with pytest.raises(gecos.CommandFailed) as refused:
            robot.move_joints(JointPositions([*target, 0.0])).result()
        assert refused.value.detail is gecos.Detail.BAD_PARAMETER
        count = len(start)
        words = f"it has {count + 1} joint positions, but the arm has {count} joints"
        assert words in str(refused.value)
        with pytest.raises(JointLimit, match="is the value in degrees") as beyond:
            robot.move_joints(JointPositions([*target[:-1], 90.0])).result()
        assert beyond.value.axis == count
        assert list(robot.joints().result().position) == pytest.approx(target, abs=1e-3)


@pytest.mark.usefixtures("here")
def test_options_come_before_what_the_file_says(lab_with_broker: Laboratory, own_arm: Path) -> None:
    lab = lab_with_broker
    options = ("--name", "OTHER", "--tool-length", "250")
    lab.start(robcl_arm(lab), own_arm, *options, ready="OTHER is ready")
    offset = gecos.Lab().create(Manipulator, "OTHER").tool_offset().result()
    assert offset.position == pytest.approx([0, 0, 0.25])


@pytest.fixture
def arm_of_the_page(tmp_path: Path) -> Path:
    """The TOML file of the arm in docs/adding-an-arm.md."""
    page = (TREE / "docs" / "adding-an-arm.md").read_text()
    for name in ("bench.toml", "bench.urdf"):
        block = re.search(rf"^`{name}`.*?^```\w+\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
        assert block
        (tmp_path / name).write_text(block[1])
    return tmp_path / "bench.toml"


@pytest.mark.usefixtures("fast_clock")
def test_the_arm_of_the_page_is_moved(lab_with_broker: Laboratory, arm_of_the_page: Path) -> None:
    lab = lab_with_broker
    lab.start(robcl_arm(lab), arm_of_the_page, ready="BENCH is ready")
    moved = lab.run(sys.executable, MOVE_TOOL, "BENCH")
    assert moved.finish() == 0, str(moved)


def test_the_error_of_the_page_is_what_the_program_says(
    lab: Laboratory, arm_of_the_page: Path
) -> None:
    good = arm_of_the_page.read_text()
    arm_of_the_page.write_text(good.replace("start_deg = [0, -20", "start_deg = [0, 200"))
    refused = lab.run(robcl_arm(lab), arm_of_the_page)
    assert refused.finish() == 2, str(refused)
    said = refused.output().replace(str(arm_of_the_page), arm_of_the_page.name)
    assert said in (TREE / "docs" / "adding-an-arm.md").read_text()


def test_help_shows_what_the_file_says(lab: Laboratory, own_arm: Path) -> None:
    helped = lab.run(robcl_arm(lab), own_arm, "--help")
    assert helped.finish() == 0, str(helped)
    assert "Serves a simulated arm of five joints" in helped.output()
    assert "(FIVE)" in helped.output() and "(100)" in helped.output()
    helped = lab.run(robcl_arm(lab), "--help")
    assert helped.finish() == 0, str(helped)
    assert "usage: robcl-arm ARM.toml [--WORD VALUE]..." in helped.output()


def test_a_bad_file_is_refused_with_its_line(lab: Laboratory, own_arm: Path) -> None:
    own_arm.write_text(FIVE_TOML.replace("60, 60, 0", "60, 60"))
    refused = lab.run(robcl_arm(lab), own_arm)
    assert refused.finish() == 2, str(refused)
    assert refused.output() == (
        f"robcl-arm: {own_arm}:7: start_deg: the list has 4 values, but the arm has 5 joints "
        "(a, b, c, d, e); give a list with an angle in degrees for each joint, at which the "
        "simulated arm starts"
    )


def test_a_missing_file_is_asked_for(lab: Laboratory) -> None:
    refused = lab.run(robcl_arm(lab), "--name", "ARM")
    assert refused.finish() == 2, str(refused)
    assert refused.lines[0] == "robcl-arm: the first argument must be the TOML file of an arm"
