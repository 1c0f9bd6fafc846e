"""Conditions of ranges in C++. NaN is never inside."""

from __future__ import annotations

from gidl.model import Primitive
from gidl.wire_nodes import ScalarNode


def range_test(x: str, number: ScalarNode) -> str:
    """ "(x >= 0.01 && x <= 1.0)"; empty where every value is inside."""
    tests = [f"{x} {sign} {bound}" for sign, _, bound in _bounds(number)]
    return f"({' && '.join(tests)})" if tests else ""


def bounds(number: ScalarNode) -> str:
    """ "{.low = 0.01, .high = 1.0}": a gecos::wire::Bounds; empty where every value is inside."""
    terms = [f".{side} = {bound}" for _, side, bound in _bounds(number)]
    return f"{{{', '.join(terms)}}}" if terms else ""


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
    """A literal of the type."""
    if kind is Primitive.FLOAT:
        return f"{float(value)!r}F"
    if kind is Primitive.DOUBLE:
        return repr(float(value))
    if kind.is_unsigned:
        return f"{value}U"
    if value == -(1 << 63):
        return "std::numeric_limits<std::int64_t>::min()"
    return str(value)
