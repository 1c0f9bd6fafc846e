"""robcl.frames: shared vectors with C++, the algebra of frames, and what is refused."""

from __future__ import annotations

import copy
import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gecos import wire
from hypothesis import given
from hypothesis import strategies as st
from robcl.frames import (
    Frame,
    InvalidFrame,
    Twist,
    Wrench,
    angle,
    deg,
    distance,
    in_deg,
    in_mm,
    interpolate,
    mm,
    near,
    rotate_x,
    rotate_y,
    rotate_z,
    translate,
)
from wire_reads import verdict_of

VECTORS = json.loads(
    (Path(__file__).parent.parent / "vectors" / "frames.json").read_text(encoding="utf-8")
)
Case = dict[str, Any]

angles = st.floats(-2 * math.pi, 2 * math.pi)
metres = st.floats(-10, 10)
frames = st.builds(Frame.from_euler_zyz, metres, metres, metres, angles, angles, angles)


def same(left: Frame, right: Frame) -> bool:
    return near(left, right, 1e-9, 1e-9)


def test_euler_angles_are_read_accurately_beside_their_singularity() -> None:
    for beside in (1e-3, 1e-5, 1e-7):
        for b in (math.pi / 2 - beside, beside - math.pi / 2):
            a, middle, c = Frame.from_euler_zyx(0, 0, 0, 0.3, b, 0.4).euler_zyx()
            assert abs(middle - b) < 1e-15
            assert abs(a - 0.3) < 1e-15 / beside and abs(c - 0.4) < 1e-15 / beside


@given(frames, frames, st.floats(0, 1))
def test_an_interpolated_frame_is_on_the_line_and_the_turn(
    start: Frame, goal: Frame, part: float
) -> None:
    between = interpolate(start, goal, part)
    assert distance(start, between) == pytest.approx(part * distance(start, goal), abs=1e-9)
    assert angle(start, between) == pytest.approx(part * angle(start, goal), abs=1e-7)
    assert angle(start, between) + angle(between, goal) == pytest.approx(
        angle(start, goal), abs=1e-7
    )


def test_interpolation_takes_a_part_from_0_to_1() -> None:
    with pytest.raises(ValueError, match=r"part is 1.5, but it must be from 0 to 1"):
        interpolate(Frame(), Frame(), 1.5)


@given(frames)
def test_a_frame_is_its_axis_and_angle(frame: Frame) -> None:
    turn = frame.rotation_vector()
    size = float(np.linalg.norm(turn))
    assert 0 <= size <= math.pi + 1e-15
    axis = turn if size > 0 else (0.0, 0.0, 1.0)
    assert same(Frame.from_axis_angle(frame.x, frame.y, frame.z, axis, size), frame)


def test_an_axis_or_an_angle_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidFrame, match=r"axis \(0, 0, 0\) has no direction"):
        Frame.from_axis_angle(0, 0, 0, (0, 0, 0), 1)
    for angle_of in (rotate_x, rotate_y, rotate_z):
        with pytest.raises(InvalidFrame, match="angle inf rad is not finite"):
            angle_of(math.inf)


@given(frames)
def test_twist_and_wrench_do_the_same_work_seen_from_anywhere(frame: Frame) -> None:
    twist = Twist((0.1, -0.2, 0.3), (1.0, 2.0, -0.5))
    wrench = Wrench((5.0, -3.0, 2.0), (0.2, 0.4, -0.6))
    seen, felt = frame.transform_twist(twist), frame.transform_wrench(wrench)
    power = np.dot(twist.linear, wrench.force) + np.dot(twist.angular, wrench.torque)
    assert np.dot(seen.linear, felt.force) + np.dot(seen.angular, felt.torque) == pytest.approx(
        power
    )


def test_a_twist_moves_the_points_of_a_body() -> None:
    frame = Frame.from_euler_zyx(0.3, -0.2, 0.5, 0.4, 0.5, 0.6)
    twist = Twist((0.1, -0.2, 0.3), (1.0, 2.0, -0.5))
    seen = frame.transform_twist(twist)
    point = np.array((0.7, 0.1, -0.4))  # of the body, in its coordinates
    velocity = frame.rotation() @ (twist.linear + np.cross(twist.angular, point))
    np.testing.assert_allclose(
        seen.linear + np.cross(seen.angular, frame.transform(point)), velocity, atol=1e-12
    )


def test_numpy_takes_a_frame_as_its_matrix() -> None:
    frame = Frame.from_euler_zyz(1, 2, 3, 0.1, 0.2, 0.3)
    np.testing.assert_array_equal(np.asarray(frame), frame.matrix())
    assert np.asarray(frame, dtype=np.float32).dtype == np.float32
    np.testing.assert_allclose(np.linalg.inv(frame), frame.inverse().matrix(), atol=1e-12)
    with pytest.raises(ValueError, match="a Frame has no array in memory"):
        frame.__array__(copy=False)


# Shared with C++


@pytest.mark.parametrize("case", VECTORS["made"])
def test_a_frame_made_from_angles_has_the_expected_matrix(case: Case) -> None:
    frame = getattr(Frame, case["make"])(*case["numbers"])
    np.testing.assert_allclose(frame.matrix(), case["matrix"], rtol=0, atol=1e-12)
    assert same(Frame.from_matrix(case["matrix"]), frame)
    back = getattr(frame, case["make"].removeprefix("from_"))()
    again = getattr(Frame, case["make"])(frame.x, frame.y, frame.z, *back)
    assert near(again, frame, 0, 1e-9)


@pytest.mark.parametrize("case", VECTORS["read"])
def test_singular_orientations_are_read_by_the_agreed_convention(case: Case) -> None:
    frame = Frame.from_matrix(case["matrix"])
    for name in case.keys() - {"matrix"}:
        np.testing.assert_allclose(getattr(frame, name)(), case[name], rtol=0, atol=1e-9)


def test_a_matrix_gives_the_quaternion_with_the_agreed_sign() -> None:
    assert len(VECTORS["signs"]) > 500
    for case in VECTORS["signs"]:
        read = Frame.from_matrix(case["matrix"]).quaternion()
        np.testing.assert_allclose(read, case["quaternion"], rtol=0, atol=1e-12)


@pytest.mark.parametrize("case", VECTORS["encoded"])
def test_a_frame_is_seven_doubles_that_come_back_exactly(case: Case) -> None:
    data = bytes.fromhex(case["bytes"])
    frame = wire.from_bytes(Frame, data)
    assert [frame.x, frame.y, frame.z, *frame.quaternion()] == case["numbers"]
    assert wire.to_bytes(frame) == data
    message = wire.to_message(frame)
    assert message.hex() == VECTORS["fingerprint"] + case["bytes"]
    assert wire.from_message(Frame, message) == frame


@pytest.mark.parametrize("case", VECTORS["refused"], ids=lambda case: case["name"])
def test_bytes_that_are_no_frame_are_refused(case: Case) -> None:
    with pytest.raises(wire.DecodeError) as caught:
        wire.from_bytes(Frame, bytes.fromhex(case["bytes"]))
    assert verdict_of(caught.value) == case["refused"]


@pytest.mark.parametrize("case", VECTORS["text"])
def test_a_frame_prints_for_people(case: Case) -> None:
    assert str(getattr(Frame, case["make"])(*case["numbers"])) == case["text"]


# Python's own


@given(frames, frames, frames)
def test_frames_are_a_group(a: Frame, b: Frame, c: Frame) -> None:
    assert same(a * a.inverse(), Frame())
    assert same(a.inverse() * a, Frame())
    assert same((a * b) * c, a * (b * c))
    assert same((a * b).inverse(), b.inverse() * a.inverse())
    assert a @ b == a * b
    np.testing.assert_allclose((a * b).matrix(), a.matrix() @ b.matrix(), rtol=0, atol=1e-12)


@given(frames, st.tuples(metres, metres, metres))
def test_points_move_with_their_frame(frame: Frame, point: tuple[float, float, float]) -> None:
    expected = frame.matrix() @ np.array([*point, 1.0])
    np.testing.assert_allclose(frame.transform(point), expected[:3], rtol=0, atol=1e-12)
    many = frame.transform([point, point])
    np.testing.assert_allclose(many, [expected[:3]] * 2, rtol=0, atol=1e-12)


@given(frames)
def test_every_reading_makes_the_same_frame_again(frame: Frame) -> None:
    place = (frame.x, frame.y, frame.z)
    # Axes that are parallel within 2e-9 rad are read as parallel, and lose that much.
    assert near(Frame.from_euler_zyz(*place, *frame.euler_zyz()), frame, 0, 1e-8)
    assert near(Frame.from_euler_zyx(*place, *frame.euler_zyx()), frame, 0, 1e-8)
    assert near(Frame.from_fixed_xyz(*place, *frame.fixed_xyz()), frame, 0, 1e-8)
    assert same(Frame.from_quaternion(*place, *frame.quaternion()), frame)
    assert same(Frame.from_matrix(frame.matrix()), frame)
    assert wire.from_bytes(Frame, wire.to_bytes(frame)) == frame
    assert 0 <= frame.euler_zyz()[1] <= math.pi
    assert abs(frame.euler_zyx()[1]) <= math.pi / 2


def test_handing_over_twice_is_no_change() -> None:
    handover = Frame.from_euler_zyz(0, 0, 0, 0, deg(180), 0)
    assert same(handover * handover, Frame())


def test_turns_follow_the_right_hand() -> None:
    np.testing.assert_allclose(rotate_x(deg(90)).transform((0, 1, 0)), (0, 0, 1), atol=1e-15)
    np.testing.assert_allclose(rotate_y(deg(90)).transform((0, 0, 1)), (1, 0, 0), atol=1e-15)
    np.testing.assert_allclose(rotate_z(deg(90)).transform((1, 0, 0)), (0, 1, 0), atol=1e-15)
    assert translate(1, 2, 3).position.tolist() == [1, 2, 3]


def test_distance_and_angle_are_exact_for_small_ones() -> None:
    here = Frame.from_euler_zyz(0.4, 0.1, 0.9, 0.5, 0.6, 0.7)
    assert distance(here, here * translate(3, 0, 4)) == pytest.approx(5)
    assert angle(here, here * rotate_y(1e-8)) == pytest.approx(1e-8, rel=1e-6)
    assert angle(here, here * rotate_z(math.pi)) == pytest.approx(math.pi)
    turned = Frame.from_quaternion(0, 0, 0, -1, 0, 0, 0)
    assert angle(Frame(), turned) == 0
    assert turned != Frame()


def test_millimetres_and_degrees_say_so() -> None:
    assert mm(200) == pytest.approx(0.2)
    assert deg(180) == pytest.approx(math.pi)
    assert in_mm(0.2) == pytest.approx(200)
    assert in_deg(math.pi) == pytest.approx(180)


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda: translate(math.nan, 0, 0), r"position \(nan, 0, 0\) m is not finite"),
        (lambda: rotate_x(math.inf), None),
        (
            lambda: Frame.from_quaternion(0, 0, 0, 1, 1, 0, 0),
            r"w, x, y, z = \(1, 1, 0, 0\) has length 1\.41421356; .*normalise it",
        ),
        (lambda: Frame.from_matrix(np.eye(3)), r"shape \(3, 3\), it must be \(4, 4\)"),
        (lambda: Frame.from_matrix(2 * np.eye(4)), r"last row .*\(0, 0, 0, 2\)"),
        (lambda: Frame.from_matrix(np.diag([2, 1, 1, 1])), "stretches or shears by 3"),
        (lambda: Frame.from_matrix(np.diag([-1, 1, 1, 1])), "mirrors"),
        (lambda: Frame.from_matrix(np.full((4, 4), math.nan)), "not finite"),
    ],
)
def test_what_is_not_a_placement_is_refused(make: Any, why: str | None) -> None:
    with pytest.raises(ValueError if why is None else InvalidFrame, match=why):
        make()


def test_a_frame_does_not_change() -> None:
    frame = translate(1, 2, 3)
    with pytest.raises(AttributeError, match="is immutable"):
        frame.x = 5  # type: ignore[misc]
    with pytest.raises(AttributeError, match="is immutable"):
        del frame._numbers
    frame.position[0] = 99
    frame.matrix()[:] = 0
    assert frame == translate(1, 2, 3)


def test_a_frame_is_a_value() -> None:
    frame = Frame.from_euler_zyz(1, 2, 3, 0.1, 0.2, 0.3)
    assert same(eval(repr(frame)), frame)
    assert copy.deepcopy(frame) == frame
    assert pickle.loads(pickle.dumps(frame)) == frame
    assert len({frame, copy.copy(frame)}) == 1
    assert frame != "a frame"
    with pytest.raises(TypeError):
        frame * 2  # type: ignore[operator]
