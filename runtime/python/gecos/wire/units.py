"""Adds units to messages: after the members of an exception, and after the limits of a range."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def mistaken_unit(value: object, low: float, high: float, unit: str) -> str:
    """Returns a question to append to an error about `value`, such as "; is the value in degrees?".
    Returns "" if there is no reason to ask.

    The question about degrees is asked if `unit` is "rad", and if `value` is outside the range from
    `low` to `high`, has a magnitude greater than pi, and would be inside the range after a
    conversion from degrees. The question about millimetres is asked likewise if `unit` is "m" and
    the magnitude of `value` is at least 1. C++ computes the same text."""
    if not isinstance(value, int | float) or low <= value <= high:
        return ""
    if unit == "rad" and abs(value) > math.pi and low <= value * math.pi / 180 <= high:
        return "; is the value in degrees?"
    if unit == "m" and abs(value) >= 1 and low <= value / 1000 <= high:
        return "; is the value in millimetres?"
    return ""


class Range:
    """The limits of a number and their unit. None means that there is no limit on that side. A
    number without a dimension, whose unit is "1", is shown without a unit."""

    __slots__ = ("high", "low", "unit")

    def __init__(self, low: Any, high: Any, unit: str = "") -> None:
        self.low, self.high, self.unit = low, high, "" if unit == "1" else unit

    def __str__(self) -> str:
        """Returns the range as messages show it, for example "[0.01, 1.0] m/s"."""
        low = "-inf" if self.low is None else self.low
        high = "inf" if self.high is None else self.high
        return f"[{low}, {high}]{f' {self.unit}' if self.unit else ''}"


def outside(value: Any, limits: Range) -> str:
    """Returns why `value` is outside `limits`, and what to do: "1.9 is outside [-1.5, 1.5] rad;
    give at most 1.5 rad". C++ computes the same text."""
    low = -math.inf if limits.low is None else limits.low
    high = math.inf if limits.high is None else limits.high
    advice = mistaken_unit(value, low, high, limits.unit)
    return f"{value} is outside {limits}{advice or _bound(value, low, high, limits.unit)}"


def _bound(value: Any, low: Any, high: Any, unit: str) -> str:
    """Returns advice that names the bound that `value` violates, such as "; give at least 5 mm"."""
    unit = f" {unit}" if unit else ""
    if value < low:
        return f"; give at least {low}{unit}"
    return f"; give at most {high}{unit}" if value > high else "; give a number"


def shown_members(values: Mapping[str, str], units: Mapping[str, str]) -> str:
    """Returns members with their units, as a text such as "axis=1, value=2.9 rad"."""
    return ", ".join(
        f"{name}={value}{f' {units[name]}' if name in units else ''}"
        for name, value in values.items()
    )
