"""A value of another type, or no enumerator at all, is refused by the name of its place."""

from __future__ import annotations

import math
import pickle
import re

import numpy as np
import pytest
from gecos import wire
from gecos.wire import EncodeError, WrongTypeError
from robcl.manipulator import Manipulator
from robcl.manipulator_types import PathType, Trajectory
from robcl.world_types import Body


def test_a_number_that_is_no_enumerator_is_refused_by_name() -> None:
    how = Trajectory(path=7)  # type: ignore[arg-type]
    with pytest.raises(
        EncodeError, match=r"^Trajectory\.path: 7 is no PathType; give one of \w+, "
    ):
        wire.to_bytes(how)


def test_the_number_of_an_enumerator_will_do() -> None:
    straight = Trajectory(path=PathType.STRAIGHT)
    number = Trajectory(path=int(PathType.STRAIGHT))  # type: ignore[arg-type]
    assert wire.to_bytes(number) == wire.to_bytes(straight)


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
