"""A value of another type, or no enumerator at all, is refused by the name of its place."""

from __future__ import annotations

import math
import pickle
import re
from enum import IntFlag

import numpy as np
import pytest
from gecos import wire
from gecos.wire import EncodeError, WrongTypeError
from gecos.wire.kinds import Flags
from robcl.manipulator import Manipulator
from robcl.manipulator_types import Blend, Configuration, Elbow, PathType, Trajectory
from robcl.world_types import Body


def test_a_number_that_is_no_enumerator_is_refused_by_name() -> None:
    how = Trajectory(path=7)  # type: ignore[arg-type]
    with pytest.raises(
        EncodeError,
        match=r"^Trajectory\.path: 7 is no PathType; give PathType\.STRAIGHT or PathType\.JOINT$",
    ):
        wire.to_bytes(how)


def test_the_number_of_an_enumerator_will_do() -> None:
    straight = Trajectory(path=PathType.STRAIGHT)
    number = Trajectory(path=int(PathType.STRAIGHT))  # type: ignore[arg-type]
    assert wire.to_bytes(number) == wire.to_bytes(straight)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (Blend.BREAK, "Blend.BREAK"),
        ("STRAIGHT", "'STRAIGHT'"),
        (True, "True"),
        (1.0, "1.0"),
        (None, "None"),
        (np.array([1, 0]), "array([1, 0])"),
        (np.array([], np.int64), "array([], dtype=int64)"),
    ],
)
def test_a_value_of_another_type_in_place_of_an_enumerator_names_the_enumerators(
    value: object, shown: str
) -> None:
    assert Blend.BREAK in PathType.__members__.values()  # its number would do
    with pytest.raises(WrongTypeError) as caught:
        wire.to_bytes(Trajectory(path=value))  # type: ignore[arg-type]
    assert str(caught.value) == (
        f"Trajectory.path: {shown} is no PathType; give PathType.STRAIGHT or PathType.JOINT"
    )
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_an_enumerator_of_another_enum_in_a_struct_within_is_refused() -> None:
    how = Trajectory(configuration=Configuration(arm=Elbow.BELOW))  # type: ignore[arg-type]
    with pytest.raises(
        WrongTypeError,
        match=r"^Configuration\.arm: Elbow\.BELOW is no Shoulder; give Shoulder\.RIGHTY or "
        r"Shoulder\.LEFTY$",
    ):
        wire.to_bytes(how)


def test_flags_of_another_bitmask_are_refused() -> None:
    class Colours(IntFlag):
        RED = 1

    class Sides(IntFlag):
        LEFT = 1
        RIGHT = 2

    kind = Flags(Sides, "I", 2, {})
    for value in (Colours.RED, Colours(0), "LEFT", True):
        with pytest.raises(WrongTypeError, match=r"is no Sides; give Sides\.LEFT or Sides\.RIGHT$"):
            kind.put(value, [], "sides")
    for good in (Sides.LEFT | Sides.RIGHT, 3, np.uint8(3)):
        out: list[bytes] = []
        kind.put(good, out, "sides")  # type: ignore[arg-type]
        assert out == [b"\0\0\0\3"]


def test_a_parameter_of_another_type_names_operation_and_parameter() -> None:
    call = object.__new__(Manipulator).move  # refused before there is need of a session
    with pytest.raises(TypeError, match=r"^move\.goal: 3\.0 is no Frame$"):
        call(3.0)


def test_a_struct_among_numbers_is_refused_by_its_own_name() -> None:
    with pytest.raises(WrongTypeError, match=r"^Body\.size: 0\.5 is no Vector$"):
        wire.to_bytes(Body(size=0.5))  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["off", "", None, 0, 1, math.nan, []], ids=repr)
def test_what_is_merely_true_or_false_is_no_boolean(value: object) -> None:
    named = re.escape(f"power.on: {value!r} is no bool") + "$"
    with pytest.raises(WrongTypeError, match=named):
        wire.number(value, "?", "power.on")
    run = wire.Fields("i?", ("a", "power.on"))
    with pytest.raises(WrongTypeError, match=named):
        run.pack(1, value)


@pytest.mark.parametrize("value", [True, np.True_])
def test_a_boolean_of_python_or_numpy_is_one(value: bool) -> None:
    assert wire.number(value, "?") == b"\1"
    assert wire.Fields("?i", ("on", "a")).pack(value, 2) == b"\1\0\0\0\2"


def test_the_refusal_is_one_of_a_value_too_and_can_be_pickled() -> None:
    with pytest.raises(EncodeError) as caught:
        wire.put(Body(), Trajectory, [], "move.how")
    again = pickle.loads(pickle.dumps(caught.value))
    assert isinstance(again, WrongTypeError)
    assert (str(again), again.field) == (str(caught.value), "move.how")
