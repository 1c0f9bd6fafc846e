"""Values with named members, as dataclasses have them."""

from __future__ import annotations

import copy
import pickle

import pytest
from gecos.record import Record, replace


class Point(Record):
    x: float
    y: float = 0.0
    length: float = 0.0

    def __post_init__(self) -> None:
        self.__dict__["length"] = abs(self.x) + abs(self.y)


class Named(Record, kw_only=True, derived=("length",)):
    name: str
    make: object = len
    length: int = 0


def test_members_are_given_in_order_or_by_name() -> None:
    assert Point(1.0) == Point(x=1.0, y=0.0) != Point(1.0, 2.0)
    assert Point(1.0, y=2.0).length == 3.0
    assert repr(Named(name="a")) == "Named(name='a', make=<built-in function len>)"


def test_derived_members_are_not_compared() -> None:
    assert Named(name="a", length=1) == Named(name="a", length=2)
    assert hash(Named(name="a", length=1)) == hash(Named(name="a", length=2))
    assert Named(name="a") != Named(name="b")
    assert Point(1.0) != (1.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("given", "named", "wrong"),
    [
        ((), {}, "x"),
        ((1.0,), {"x": 2.0}, "x"),
        ((1.0,), {"z": 2.0}, "z"),
        ((1.0, 2.0, 3.0, 4.0), {}, "4 values"),
    ],
)
def test_wrong_members_are_named(
    given: tuple[float, ...], named: dict[str, float], wrong: str
) -> None:
    with pytest.raises(TypeError, match=f"Point has the members x, y, length, .*wrong: {wrong}$"):
        Point(*given, **named)


def test_members_of_some_classes_are_given_only_by_name() -> None:
    with pytest.raises(TypeError, match="of which 0 may be given without their names"):
        Named("a")  # type: ignore[misc]


def test_a_value_is_immutable_and_can_be_replaced() -> None:
    point = Point(1.0)
    with pytest.raises(AttributeError, match="Point is immutable: x cannot be set"):
        point.x = 2.0  # type: ignore[misc]
    with pytest.raises(AttributeError, match="x cannot be deleted"):
        del point.x
    assert replace(point, y=3.0) == Point(1.0, 3.0)


def test_a_value_can_be_copied_and_sent() -> None:
    assert copy.deepcopy(Point(1.0)) == pickle.loads(pickle.dumps(Point(1.0))) == Point(1.0)
