"""Sensor-guided motion from other programs: what becomes of an arm whose corrections stop."""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import gecos
import numpy as np
import pytest
from arm_chain import ArmChain
from processes import Laboratory, until
from robcl.articulated_arm import ArticulatedArm
from robcl.frames import Frame, distance, mm, near, translate
from robcl.manipulator import (
    CorrectionsStopped,
    FollowLimits,
    FollowMode,
    FollowState,
    Manipulator,
)
from robcl.six_axis import Joints, SixAxis
from test_arm_file import ARMS, robcl_arm
from test_examples import LANGUAGES, carried_out, example

pytestmark = pytest.mark.usefixtures("here")

# A client that gets no processor for 48 ms, on a loaded machine, is what the watchdog is for: then
# a test tries again.
TRIES = 3

Following = gecos.Command[None, FollowState]


@pytest.fixture
def audit(lab: Laboratory, tmp_path: Path) -> Path:
    """The audit of servers that start after this."""
    lab.env["GECOS_AUDIT_DIR"] = str(tmp_path / "audit")
    return tmp_path / "audit" / "audit.jsonl"


def followed(robot: Manipulator, limits: FollowLimits | None = None) -> Following:
    """A `follow` that takes corrections."""
    follow = robot.follow(FollowMode.IN_TOOL, limits)
    while follow.feedback() is None and follow.wait(0.001) is gecos.State.RUNNING:
        pass
    return follow


def fed_until(
    alter: gecos.Writer[Frame], follow: Following, happened: Callable[[FollowState], bool]
) -> bool:
    """Sends corrections that move nothing, so that the watchdog does not end the command. Returns
    False if it has ended all the same."""
    while follow.wait(0.004) is gecos.State.RUNNING:
        alter.send(Frame())
        state = follow.feedback()
        if state is not None and happened(state):
            return True
    return False


ON_ALL_ARMS = pytest.mark.parametrize("arm", ["rx90", "puma560", "iiwa14"])


def serve_arm(lab: Laboratory, arm: str) -> Path:
    """Serves an arm as RX90, the name that the example knows; its file."""
    file = ARMS / f"{arm}.toml"
    lab.start(robcl_arm(lab), file, "--name", "RX90", ready="RX90 is ready")
    return file


@LANGUAGES
@ON_ALL_ARMS
def test_corrections_at_one_kilohertz_add_up(
    arm: str, language: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    serve_arm(lab, arm)
    guide = example(lab, "17_follow_a_sensor", "follow_a_sensor", language)
    for _ in range(TRIES):
        printed = carried_out(lab.run(*guide))
        if printed[0].startswith("500"):
            break
    assert printed == ["500 corrections, 0 dropped", "moved by 50.0 mm"]


@ON_ALL_ARMS
def test_the_set_points_are_exactly_at_the_sum_of_the_corrections(
    arm: str, lab_with_broker: Laboratory
) -> None:
    chain = ArmChain(serve_arm(lab_with_broker, arm))
    robot = gecos.Lab().create(ArticulatedArm if arm == "iiwa14" else SixAxis, "RX90")
    offset = robot.tool_offset().result()

    def commanded_tool() -> Frame:  # the set points have no noise of the encoders
        return chain.base_from_flange(robot.commanded_joints().result().position) * offset

    with gecos.actor(robot):
        alter = robot.alter.writer()
        for _ in range(TRIES):
            before = commanded_tool()
            follow = followed(robot)
            alter.feeds(follow)
            for _ in range(50):
                for _ in range(10):
                    alter.send(translate(0.0, 0.0, mm(0.1)))
                follow.wait(0.010)  # 1 kHz on the average
            if fed_until(alter, follow, lambda state: state.distance_left < 1e-9):
                break
        state = follow.feedback()
        assert state is not None and state.dropped == 0 and state.applied >= 500
        assert near(commanded_tool(), before * translate(0.0, 0.0, mm(50)), 1e-6, 1e-6)
        follow.cancel()
        follow.wait()
        assert alter.report().result().lost == 0


def test_a_correction_reaches_the_drives_in_the_next_cycle(lab_with_arm: Laboratory) -> None:
    robot = gecos.Lab().create(SixAxis, "RX90")
    cycle = robot.cycle().result()
    commanded = robot.commanded_joints.stream()
    took = []
    with gecos.actor(robot):
        alter = robot.alter.writer()
        follow = followed(robot)
        alter.feeds(follow)
        for i in range(20):
            before = standing_command(commanded)
            sent = time.time()
            alter.send(translate(0.0, 0.0001 if i % 2 else -0.0001, 0.0))
            sample = commanded.next(1)
            while sample.value.position[0] == before:
                sample = commanded.next(1)
            took.append(sample.stamp - sent)
        follow.cancel()
    # One cycle and 100 us are promised; other programs may use the processors of the test.
    assert statistics.median(took) < 5 * (cycle + 100e-6)


def standing_command(commanded: gecos.Stream[Joints]) -> float:
    """The set point of joint 1, once it has been the same in four cycles."""
    held, same = float(commanded.next(1).value.position[0]), 1
    while same < 4:
        now = float(commanded.next(1).value.position[0])
        held, same = now, same + 1 if now == held else 1
    return held


def test_a_sample_of_the_arm_is_read_directly_after_its_measurement(
    lab_with_arm: Laboratory,
) -> None:
    stream = gecos.Lab().create(SixAxis, "RX90").joints.stream()
    ages = [stream.next(1).age for _ in range(250)]
    assert statistics.median(ages) < 5 * 500e-6


@LANGUAGES
def test_an_arm_stands_when_the_program_that_guides_it_is_killed(
    language: str, audit: Path, lab_with_arm: Laboratory
) -> None:
    lab = lab_with_arm
    robot = gecos.Lab().create(Manipulator, "RX90")
    start = robot.tool().result()
    for _ in range(TRIES):
        guide = lab.start(*example(lab, "17_follow_a_sensor", "follow_a_sensor", language))
        until(lambda: not robot.standing().result(), "the arm moves")
        guide.kill()
        at_kill = robot.tool().result()
        if not guide.lines:  # it prints at its end
            break
    assert not guide.lines
    until(lambda: robot.standing().result(), "the arm stands")
    stood = robot.tool().result()
    # .1 m/s: the watchdog is 48 ms, braking takes 33 ms, and the calls take some time, too.
    assert distance(at_kill, stood) < 0.1 * (0.048 + 0.033) + 0.002
    tool = robot.tool.stream()
    places = np.array([tool.next(1).value.position for _ in range(250)])  # m, of a second
    drift = places[-50:].mean(axis=0) - places[:50].mean(axis=0)  # the encoders have noise
    assert np.linalg.norm(drift) < 2e-5
    assert np.linalg.norm(places - stood.position, axis=1).max() < 1e-4
    with gecos.actor(robot):  # the status is free again
        robot.move(start).result()
    assert outcome_of_follow(audit).state is gecos.State.COMMAND_FAILED


def outcome_of_follow(audit: Path) -> gecos.Detail:
    """How the last `follow` ended, of which the program that asked for it was not told."""
    until(lambda: "outcome" in lines_of_follow(audit)[-1], "the command ends")
    return gecos.Detail[str(lines_of_follow(audit)[-1]["outcome"])]


def lines_of_follow(audit: Path) -> list[dict[str, object]]:
    lines = [json.loads(line) for line in audit.read_text().splitlines()]
    return [line for line in lines if line.get("operation") == "follow"]


def test_corrections_beyond_the_limit_of_the_caller_are_dropped_and_counted(
    lab_with_arm: Laboratory,
) -> None:
    robot = gecos.Lab().create(Manipulator, "RX90")
    with gecos.actor(robot):
        alter = robot.alter.writer()
        for _ in range(TRIES):
            follow = followed(robot, FollowLimits(distance=mm(5)))
            alter.feeds(follow)
            for _ in range(8):
                alter.send(translate(0.0, mm(1), 0.0))
            with pytest.raises(CorrectionsStopped) as stopped:
                follow.result()
            state = stopped.value.state
            if state.applied + state.dropped == 8:
                break
        assert (state.applied, state.dropped) == (5, 3)


def test_at_a_limit_the_arm_holds_and_comes_back(lab_with_arm: Laboratory) -> None:
    robot = gecos.Lab().create(SixAxis, "RX90")
    home = robot.joints().result()
    start = robot.tool().result()
    held = back = False
    with gecos.actor(robot):
        alter = robot.alter.writer()
        for _ in range(TRIES):
            robot.move_joints(home).result()
            follow = followed(robot, FollowLimits(distance=3.0))
            alter.feeds(follow)
            alter.send(translate(0.0, 0.0, -2.0))  # m, up
            held = fed_until(alter, follow, lambda state: holds(state))
            alter.send(translate(0.0, 0.0, 2.0))
            back = fed_until(
                alter, follow, lambda state: not holds(state) and state.distance_left < 1e-9
            )
            if held and back:
                break
        assert held and back
        follow.cancel()
        assert follow.wait() is gecos.State.COMMAND_FAILED
        assert follow.progress().detail is gecos.Detail.CANCELED
        assert distance(start, robot.tool().result()) < 2e-4


def holds(state: FollowState) -> bool:
    return state.out_of_reach or state.limit_axis != 0


def test_without_corrections_follow_fails_after_the_watchdog(lab_with_arm: Laboratory) -> None:
    robot = gecos.Lab().create(Manipulator, "RX90")
    with gecos.actor(robot):
        begun = time.monotonic()
        with pytest.raises(CorrectionsStopped) as stopped:
            robot.follow(FollowMode.IN_TOOL).result()
        assert stopped.value.state.applied == 0
        assert time.monotonic() - begun < 2


def test_over_lcm_it_is_refused_with_the_term_that_lcm_does_not_meet(
    lab_with_arm: Laboratory,
) -> None:
    robot = gecos.Lab().create(Manipulator, "RX90", medium="lcm")
    with gecos.actor(robot):
        with pytest.raises(gecos.ConnectionFailed, match=r"media=shm\|can: lcm is not") as refused:
            robot.follow(FollowMode.IN_TOOL).result()
        assert refused.value.detail is gecos.Detail.QOS_UNAVAILABLE
        with pytest.raises(gecos.ConnectionFailed, match=r"media=shm\|can: lcm is not"):
            robot.alter.writer()


def test_a_sample_that_is_no_frame_ends_the_command(lab_with_arm: Laboratory) -> None:
    robot = gecos.Lab().create(Manipulator, "RX90")
    with gecos.actor(robot):
        alter = robot.alter.writer()
        before = robot.tool().result()
        for _ in range(TRIES):
            follow = followed(robot)
            alter.feeds(follow)
            alter.send(no_frame())
            with pytest.raises((gecos.CommandFailed, CorrectionsStopped)) as failed:
                follow.result()
            if not isinstance(failed.value, CorrectionsStopped):
                break
        assert "a sample of 'alter' is no correction" in str(failed.value)
        assert failed.value.detail is gecos.Detail.FAULT
        assert distance(before, robot.tool().result()) < 1e-4


def no_frame() -> Frame:
    """A frame with a position that is not a number, which no constructor makes."""
    frame = translate(0.0, 0.0, 0.0)
    object.__setattr__(frame, "_numbers", (float("nan"), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    return frame


def test_the_arm_tells_its_cycle(lab_with_arm: Laboratory) -> None:
    assert gecos.Lab().create(Manipulator, "RX90").cycle().result() == 0.004


@LANGUAGES
def test_over_lcm_a_program_is_told_why_it_cannot_follow(
    language: str, lab_with_arm: Laboratory, tmp_path: Path
) -> None:
    """A client with another runtime directory counts as one of another host."""
    lab_with_arm.env |= {"GECOS_RUNTIME_DIR": str(tmp_path), "GECOS_BROKER": "lcm"}
    guide = example(lab_with_arm, "17_follow_a_sensor", "follow_a_sensor", language)
    client = lab_with_arm.run(*guide)
    assert client.finish() == 1, str(client)
    assert "QOS_UNAVAILABLE" in client.output() and "media=shm|can: lcm is not" in client.output()
