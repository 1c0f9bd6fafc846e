"""Units in messages: behind the values of an exception and the limits of a range."""

from __future__ import annotations

import math
from collections.abc import Mapping

# What a value may have been given in, and its factor to the unit.
_MISTAKEN = {"rad": ("degrees", math.pi / 180), "m": ("millimetres", 1e-3)}


def mistaken_unit(value: object, low: float, high: float, unit: str) -> str:
    """A question to add to the message about `value`, which is outside `low` to `high` in `unit`,
    but inside if it was given in degrees or millimetres: "; is the value in degrees?". Else empty.
    """
    name, factor = _MISTAKEN.get(unit, ("", 0.0))
    if not name or not isinstance(value, int | float):
        return ""
    return f"; is the value in {name}?" if low <= value * factor <= high else ""


def shown_members(values: Mapping[str, str], units: Mapping[str, str]) -> str:
    """Members and their units: "axis=1, value=2.9 rad"."""
    return ", ".join(
        f"{name}={value}{f' {units[name]}' if name in units else ''}"
        for name, value in values.items()
    )
