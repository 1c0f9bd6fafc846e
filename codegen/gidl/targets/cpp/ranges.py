"""C++ text that tests ranges of numbers. NaN is outside of every range."""

from __future__ import annotations

from gidl.model import Primitive
from gidl.targets.naming import range_text
from gidl.wire.wire_nodes import ScalarNode


def range_test(x: str, number: ScalarNode) -> str:
    """Returns a test of the range, for example "(x >= 0.01 && x <= 1.0)". The text is empty if
    every value of the type is allowed."""
    tests = [f"{x} {sign} {bound}" for sign, _, bound in _bounds(number)]
    return f"({' && '.join(tests)})" if tests else ""


def bounds(number: ScalarNode) -> str:
    """Returns an initialiser for gecos::wire::Bounds, for example "{0.01, 1.0}" or "{.low = 0.01}".
    The text is empty if every value of the type is allowed."""
    found = _bounds(number)
    terms = [bound if len(found) == 2 else f".{side} = {bound}" for _, side, bound in found]
    return f"{{{', '.join(terms)}}}" if terms else ""


def limits_text(number: ScalarNode) -> str:
    """Returns the limits of a number as messages show them, in a string literal: for example
    `"[0.01, 1.0] m/s"`. @pre the number has limits"""
    assert number.limits is not None
    return f'"{range_text(number.limits, number.unit)}"'


def _bounds(number: ScalarNode) -> list[tuple[str, str, str]]:
    limits = number.bounds
    if limits is None:
        return []
    both = ((">=", "low", limits.minimum), ("<=", "high", limits.maximum))
    return [
        (sign, side, number_text(bound, number.primitive))
        for sign, side, bound in both
        if bound is not None
    ]


def number_text(value: int | float, kind: Primitive) -> str:
    """A C++ literal of the primitive type `kind`."""
    if kind is Primitive.FLOAT:
        return f"{float(value)!r}F"
    if kind is Primitive.DOUBLE:
        return repr(float(value))
    if kind.is_unsigned:
        return f"{value}U"
    if value == -(1 << 63):
        return "std::numeric_limits<std::int64_t>::min()"
    return str(value)
