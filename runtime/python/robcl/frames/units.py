"""Numbers come in and go out in SI. Millimetres and degrees exist here only, and say so."""

from math import pi


def mm(millimetres: float) -> float:
    """Millimetres as metres."""
    return millimetres * 1e-3


def deg(degrees: float) -> float:
    """Degrees as radians."""
    return degrees * (pi / 180.0)


def in_mm(metres: float) -> float:
    """Metres as millimetres, for people."""
    return metres * 1e3


def in_deg(radians: float) -> float:
    """Radians as degrees, for people."""
    return radians * (180.0 / pi)
