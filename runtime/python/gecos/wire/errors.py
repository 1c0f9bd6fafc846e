"""Errors of decoding and of encoding."""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag
from operator import index
from typing import Any

from gecos.wire.units import Range, outside

HIDDEN = "***"
"""The text that error messages and logs show in place of a secret."""


class DecodeProblem(Enum):
    """The reasons why bytes are refused. Names and texts equal those in C++."""

    TRUNCATED = "the bytes end before the value does"
    INVALID_BOOLEAN = "a boolean must be 0 or 1"
    NEGATIVE_COUNT = "the count is negative"
    OVER_BOUND = "more elements than allowed"
    MISSING_NUL = "the string does not end with NUL"
    NUL_IN_STRING = "the string contains NUL"
    INVALID_UTF8 = "the string is not UTF-8"
    TOO_DEEP = "nested deeper than 16"
    TRAILING_BYTES = "bytes are left over"
    UNKNOWN_ENUMERATOR = "no enumerator has this number"
    UNKNOWN_UNION_TAG = "the union's discriminator and members do not agree"
    OUT_OF_RANGE = "outside its declared range"
    UNSORTED_MAP = "the map's keys are not ascending"
    WRONG_FINGERPRINT = "a message of another type"
    INVALID_VALUE = "not a valid value of its type"


class DecodeError(ValueError):
    """The bytes do not encode a valid value. The error names the field, the byte and the reason.
    `why` replaces the general reason, for example by "7 is no Speed; give one of SLOW, FAST"."""

    def __init__(self, problem: DecodeProblem, offset: int, field: str = "", why: str = "") -> None:
        named = f"field '{field}' " if field else ""
        super().__init__(f"{named}at byte {offset}: {why or problem.value}")
        self.problem = problem
        self.offset = offset
        self.field = field
        self.why = why

    def __reduce__(self) -> tuple[type[DecodeError], tuple[DecodeProblem, int, str, str]]:
        return DecodeError, (self.problem, self.offset, self.field, self.why)


class JsonError(ValueError):
    """The text is not JSON of the expected type. `path` is the place in the value, and `why` is the
    reason."""

    def __init__(self, path: str, why: str) -> None:
        super().__init__(f"{path}: {why}" if path else why)
        self.path = path
        self.why = why

    def __reduce__(self) -> tuple[type[JsonError], tuple[str, str]]:
        return JsonError, (self.path, self.why)


class EncodeError(ValueError):
    """The value cannot be encoded. `field` is the name of its field, and `why` is the reason."""

    def __init__(self, field: str, why: str) -> None:
        super().__init__(f"{field}: {why}" if field else why)
        self.field = field
        self.why = why

    def __reduce__(self) -> tuple[type[EncodeError], tuple[str, str]]:
        return EncodeError, (self.field, self.why)


class WrongTypeError(EncodeError, TypeError):
    """The type of the value differs from the type of its field. `advice` says what to give."""

    def __init__(self, field: str, value: object, kind: type, advice: str = "") -> None:
        named = f"{type(value).__name__}.{value.name}" if isinstance(value, Enum) else repr(value)
        super().__init__(field, f"{named} is no {kind.__name__}{advice}")
        self._given = (field, value, kind, advice)

    def __reduce__(self) -> tuple[type[WrongTypeError], tuple[str, object, type, str]]:  # type: ignore[override]
        return WrongTypeError, self._given


def brief(value: object) -> str:
    """Returns `repr(value)`. For a whole number that is too large for Python to print, returns its
    size."""
    try:
        return repr(value)
    except ValueError:  # the number has more than 4300 digits
        assert isinstance(value, int)
        return f"a number of {value.bit_length()} bits"


def unfit(value: object, meaning: str) -> str:
    """Returns the text of an error: `value` is not `meaning`, and what to do. `meaning` is a kind
    of number, for example "a whole number"."""
    advice = "" if hasattr(value, "__float__") else "; give a number"
    if isinstance(value, str):
        advice = "; write the number without quotes and unit"
    return f"{brief(value)} is not {meaning}{advice}"


def expect(value: object, kind: type, field: str) -> None:
    if not isinstance(value, kind):
        raise WrongTypeError(field, value, kind)


def expect_boolean(value: object, field: str) -> None:
    """Accepts True and False of Python and numpy. Raises WrongTypeError for all other values."""
    if type(value) is not bool and type(value).__name__ not in ("bool_", "bool"):
        raise WrongTypeError(field, value, bool)


def expect_enumerator(value: Any, kind: type[IntEnum], field: str) -> None:
    """Accepts an enumerator of `kind`, or the number of an enumerator."""
    if type(value) is kind:
        return
    expect_number_of(value, kind, field)
    if value not in kind.__members__.values():
        raise EncodeError(field, f"{brief(value)} is no {kind.__name__}{_one_of(kind)}")


def expect_number_of(value: object, kind: type[IntEnum] | type[IntFlag], field: str) -> None:
    """Accepts members of `kind` and numbers. Refuses members of other enums, booleans and all that
    is no whole number."""
    if isinstance(value, kind):
        return
    if isinstance(value, Enum | bool) or not _is_whole(value):
        raise WrongTypeError(field, value, kind, _one_of(kind))


def _is_whole(value: Any) -> bool:
    try:
        index(value)
    except TypeError:  # an array has `__index__`, too
        return False
    return True


def _one_of(kind: type[Enum]) -> str:
    """Returns advice such as "; give Speed.SLOW or Speed.FAST"."""
    *others, last = (f"{kind.__name__}.{name}" for name in kind.__members__)
    return f"; give {', '.join(others)} or {last}" if others else f"; give {last}"


class RangeError(EncodeError):
    """A number is outside the range of its field."""

    def __init__(self, field: str, value: Any, limits: Range) -> None:
        super().__init__(field, outside(value, limits))
        self.value = value
        self.limits = limits

    def __reduce__(self) -> tuple[type[EncodeError], tuple[str, str]]:
        return EncodeError, (self.field, self.why)
