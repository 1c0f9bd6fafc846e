"""Conversions of millimetres and degrees. All other functions of robcl take and return SI units."""

from math import pi


def mm(millimetres: float) -> float:
    """Converts millimetres to metres."""
    return millimetres * 1e-3


def deg(degrees: float) -> float:
    """Converts degrees to radians."""
    return degrees * (pi / 180.0)


def in_mm(metres: float) -> float:
    """Converts metres to millimetres, for display."""
    return metres * 1e3


def in_deg(radians: float) -> float:
    """Converts radians to degrees, for display."""
    return radians * (180.0 / pi)
