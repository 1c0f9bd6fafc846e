"""Parses texts inside annotations: durations, rates, and the names of hand-written types."""

from __future__ import annotations

import re
from fractions import Fraction

_DURATION = re.compile(r"(\d+(?:\.\d+)?)\s*(ns|us|µs|ms|s|min|h)\Z")
_RATE = re.compile(r"(\d+(?:\.\d+)?)\s*(mHz|Hz|kHz)\Z")
_CPP_TYPE = re.compile(r"((?:::)?[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*)\s*<([^<>\s]+)>\Z")
_PYTHON_TYPE = re.compile(r"([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*):([A-Za-z_]\w*)\Z")

_NANOSECONDS = {
    "ns": 1, "us": 10**3, "µs": 10**3, "ms": 10**6, "s": 10**9, "min": 60 * 10**9,
    "h": 3600 * 10**9,
}  # fmt: skip
_HERTZ = {"mHz": Fraction(1, 1000), "Hz": Fraction(1), "kHz": Fraction(1000)}
_LONGEST_NS = 1 << 62


def duration_ns(text: str) -> int | None:
    """Returns a duration such as "5ms" in whole nanoseconds; None if the text is not a positive
    duration."""
    match = _DURATION.match(text)
    if match is None:
        return None
    exact = Fraction(match.group(1)) * _NANOSECONDS[match.group(2)]
    return int(exact) if exact.denominator == 1 and 0 < exact <= _LONGEST_NS else None


def rate_hz(text: str) -> float | None:
    """Returns a rate such as "250Hz" in hertz; None if the text is not a positive rate of at most 1
    MHz."""
    match = _RATE.match(text)
    if match is None:
        return None
    exact = Fraction(match.group(1)) * _HERTZ[match.group(2)]
    return float(exact) if 0 < exact <= 10**6 else None


def cpp_type(text: str) -> tuple[str, str] | None:
    """Returns type and header from a text such as "robcl::Frame <robcl/frames/frame.hpp>"."""
    match = _CPP_TYPE.match(text)
    return (match.group(1).removeprefix("::"), match.group(2)) if match else None


def python_type(text: str) -> tuple[str, str] | None:
    """Returns module and class from a text such as "robcl.frames:Frame"."""
    match = _PYTHON_TYPE.match(text)
    return (match.group(1), match.group(2)) if match else None
