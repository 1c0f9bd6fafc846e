"""Adds units to messages: after the members of an exception, and after the limits of a range."""

from __future__ import annotations

import math
from collections.abc import Mapping

# For a unit: the other unit in which a value may have been given by mistake, and its size in the
# unit.
_MISTAKEN = {"rad": ("degrees", math.pi / 180), "m": ("millimetres", 1e-3)}


def mistaken_unit(value: object, low: float, high: float, unit: str) -> str:
    """Returns a question to add to the message about `value`, which is outside the range from `low`
    to `high` in `unit`. If the value would be inside in degrees or millimetres, this is a text such
    as "; is the value in degrees?". Otherwise it is empty."""
    name, factor = _MISTAKEN.get(unit, ("", 0.0))
    if not name or not isinstance(value, int | float):
        return ""
    return f"; is the value in {name}?" if low <= value * factor <= high else ""


def shown_members(values: Mapping[str, str], units: Mapping[str, str]) -> str:
    """Returns members with their units, as a text such as "axis=1, value=2.9 rad"."""
    return ", ".join(
        f"{name}={value}{f' {units[name]}' if name in units else ''}"
        for name, value in values.items()
    )
