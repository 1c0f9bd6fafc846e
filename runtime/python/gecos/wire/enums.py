"""Prints enumerators by name, as C++ does. Python 3.11 prints an IntEnum as a number."""

from __future__ import annotations

from enum import IntEnum
from typing import TypeVar

_EnumT = TypeVar("_EnumT", bound=type[IntEnum])


def printed_by_name(kind: _EnumT) -> _EnumT:
    """Makes `str` and `format` of an enumerator give its name. A format such as "03d" still formats
    the number."""
    kind.__str__ = _name  # type: ignore[method-assign, assignment]
    kind.__format__ = _formatted  # type: ignore[method-assign, assignment]
    return kind


def _name(self: IntEnum) -> str:
    return self.name


def _formatted(self: IntEnum, spec: str) -> str:
    is_number = spec[-1:] in ("b", "c", "d", "n", "o", "x", "X", "e", "f", "g", "%")
    return format(int(self), spec) if is_number else format(self.name, spec)
