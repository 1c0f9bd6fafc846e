"""Codecs in one go: generated structs tell what they are made of, and C++ does the usual case.

    @plans.planned("qd", plans.array("d", 7))  # two numbers and an array
    @dataclass(slots=True)
    class Sample: ...

What is not usual (a value that its field cannot carry, bytes that are wrong, a number that only
Python knows to be one) is left to the `encode` and `decode` that the struct has in Python, from
the start; so is everything where the extension `gecos.wire._plans` is not there. Nobody but a
clock sees the difference.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from enum import IntEnum
from typing import Any, TypeAlias, TypeVar

from gecos.wire.decode import Decoder

try:
    from gecos.wire import _plans
except ImportError:  # a tool without the extension
    COMPILED = False
else:
    COMPILED = True
    _plans.prepare(Decoder)

Step: TypeAlias = str | tuple[Any, ...]
"""What members are: the codes of numbers as for `wire.Fields`, or what a function below gives."""

_KindT = TypeVar("_KindT", bound=type[Any])
_FunctionT = TypeVar("_FunctionT", bound=Callable[..., Any])


def ranged(code: str, low: float | None, high: float | None) -> Step:
    """A number within limits; None leaves a side open."""
    return ("ranged", code, low, high)


def enumerator(code: str, kind: type[IntEnum], otherwise: IntEnum | None = None) -> Step:
    """`otherwise` stands for a number that no enumerator has."""
    return ("enumerator", code, kind, otherwise)


def array(code: str, *shape: int, low: float | None = None, high: float | None = None) -> Step:
    return ("array", code, shape, low, high)


def numbers(code: str, most: int, low: float | None = None, high: float | None = None) -> Step:
    return ("numbers", code, most, low, high)


def text(most: int) -> Step:
    return ("text", most)


def octets(most: int) -> Step:
    return ("octets", None, most)


def fixed_octets(size: int) -> Step:
    return ("octets", size, size)


def struct(kind: type) -> Step:
    """One that has a plan."""
    return ("struct", kind)


def block(kind: type) -> Step:
    """An appendable one that has a plan."""
    return ("block", kind)


def optional(inner: Step) -> Step:
    return ("optional", inner)


def items(inner: Step, least: int, most: int) -> Step:
    """A list; each element takes at least `least` bytes."""
    return ("items", inner, least, None, most)


def fixed_items(inner: Step, least: int, size: int) -> Step:
    return ("items", inner, least, size, size)


def planned(*steps: Step, missing: int = 0, open: bool = False) -> Callable[[_KindT], _KindT]:
    """Tells of a generated struct what its members are, in the order of its constructor.

    An older writer leaves out as many of the last as `missing` says, which then have their
    defaults; when it is `open`, what a newer writer added is skipped.
    """

    def tell(kind: _KindT) -> _KindT:
        if not COMPILED:
            return kind
        members = fields(kind)
        single = [each for step in steps for each in (step if isinstance(step, str) else [step])]
        described = [(member.name, step) for member, step in zip(members, single, strict=True)]
        defaults = [member.default for member in members[len(members) - missing :]]
        kind.encode, kind.decode = _plans.struct(
            kind, kind.fingerprint(), described, defaults, open, kind.encode, kind.decode
        )
        return kind

    return tell


def accelerated(function: _FunctionT) -> _FunctionT:
    """A function of `gecos.wire` that is compiled for the structs that have plans."""
    return _plans.entry(function.__name__, function) if COMPILED else function
