"""Decodes values from untrusted bytes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from enum import IntEnum, IntFlag
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias, TypeVar

from gecos.wire.codes import (
    MAX_COUNT,
    MAX_DEPTH,
    MAX_ZERO_WIDTH,
    READERS,
    arrays,
)
from gecos.wire.errors import DecodeError, DecodeProblem
from gecos.wire.units import Range, outside

if TYPE_CHECKING:
    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[Any]


_read_int32 = struct.Struct(">i").unpack_from
_EnumT = TypeVar("_EnumT", bound=IntEnum)
_FlagsT = TypeVar("_FlagsT", bound=IntFlag)
_KeyT = TypeVar("_KeyT")
_ValueT = TypeVar("_ValueT")


class Decoder:
    """Decodes values from untrusted bytes; the first error raises DecodeError.

    A count of elements is accepted only if enough bytes for the elements follow.
    """

    __slots__ = ("data", "depth", "end", "offset")

    data: bytes | bytearray | memoryview
    offset: int
    end: int
    depth: int

    def __init__(self, data: bytes | bytearray | memoryview) -> None:
        if type(data) is memoryview and (data.format != "B" or data.ndim != 1):
            data = data.cast("B")
        self.data = data
        self.offset = 0
        self.end = len(data)
        self.depth = 0

    @property
    def remaining(self) -> int:
        return self.end - self.offset

    def number(self, code: str, field: str = "") -> Any:
        """Reads one number. `code` is a number code as in `Fields`."""
        reader = READERS[code]
        offset = self.offset
        if offset + reader.size > self.end:
            self.refuse(DecodeProblem.TRUNCATED, field)
        value = reader.unpack_from(self.data, offset)[0]
        if code == "?":
            if value > 1:
                self.refuse(DecodeProblem.INVALID_BOOLEAN, field)
            value = value == 1
        self.offset = offset + reader.size
        return value

    def string(self, most: int = MAX_COUNT, field: str = "") -> str:
        """Reads a string. `most` is the limit for its UTF-8 bytes, without the NUL."""
        start = self.offset
        first = start + 4
        if first <= self.end:
            data = self.data
            last: int = first + _read_int32(data, start)[0] - 1
            if first <= last < self.end and last - first <= most and data[last] == 0:
                try:
                    text = str(data[first:last], "utf-8")
                except UnicodeDecodeError:
                    raise self._string_error(most, field) from None
                if "\0" not in text:
                    self.offset = last + 1
                    return text
        raise self._string_error(most, field)

    def _string_error(self, most: int, field: str) -> DecodeError:
        """Returns the error of the string at `offset`. The checks are made in the same order as in
        C++."""
        size = self.remaining - 4
        length: int = _read_int32(self.data, self.offset)[0] if size >= 0 else 0
        raw = bytes(self.data[self.offset + 4 : self.offset + 4 + max(min(length, size), 0)])
        if size < 0:
            problem = DecodeProblem.TRUNCATED
        elif length < 1:
            problem = DecodeProblem.NEGATIVE_COUNT
        elif length - 1 > most:
            problem = DecodeProblem.OVER_BOUND
        elif length > size:
            problem = DecodeProblem.TRUNCATED
        elif raw[-1] != 0:
            problem = DecodeProblem.MISSING_NUL
        elif b"\0" in raw[:-1]:
            problem = DecodeProblem.NUL_IN_STRING
        else:
            problem = DecodeProblem.INVALID_UTF8
        return DecodeError(problem, self.offset, field)

    def count(self, min_bytes_each: int, most: int = MAX_COUNT, field: str = "") -> int:
        """Reads a count of elements, and checks that at least `min_bytes_each` bytes follow for
        each element."""
        start = self.offset
        if start + 4 > self.end:
            self.refuse(DecodeProblem.TRUNCATED, field)
        number: int = _read_int32(self.data, start)[0]
        if number < 0:
            self.refuse(DecodeProblem.NEGATIVE_COUNT, field)
        if number > most or (min_bytes_each == 0 and number > MAX_ZERO_WIDTH):
            self.refuse(DecodeProblem.OVER_BOUND, field)
        if number * min_bytes_each > self.end - start - 4:
            self.refuse(DecodeProblem.TRUNCATED, field)
        self.offset = start + 4
        return number

    def ranged(
        self, code: str, low: Any, high: Any, field: str = "", limits: Range | None = None
    ) -> Any:
        """Reads a number of `code` that must be from `low` to `high`. None means that there is no
        limit on that side. `limits` is the range as error messages show it."""
        value = self.number(code, field)
        if (low is not None and not value >= low) or (high is not None and not value <= high):
            why = outside(value, limits or Range(low, high))
            self.refuse_range(field, READERS[code].size, why)
        return value

    def refuse_range(self, field: str, width: int, why: str = "") -> NoReturn:
        """Raises OUT_OF_RANGE for the number that starts `width` bytes before `offset`."""
        raise DecodeError(DecodeProblem.OUT_OF_RANGE, self.offset - width, field, why)

    def numbers(
        self,
        code: str,
        most: int = MAX_COUNT,
        field: str = "",
        low: Any = None,
        high: Any = None,
        limits: Range | None = None,
    ) -> Array:
        """Reads a sequence of numbers: its count, then the numbers."""
        start = self.offset
        first = start + 4
        kind, wire, native, size = arrays(code)
        if first <= self.end and code != "?" and low is high is None:
            number = _read_int32(self.data, start)[0]
            after = first + number * size
            if 0 <= number <= most and after <= self.end:  # the usual case, handled fast
                self.offset = after
                return kind(number, wire, self.data, first).astype(native)
        return self.array(code, self.count(size, most, field), field, low, high, limits)

    def array(
        self,
        code: str,
        number: int,
        field: str = "",
        low: Any = None,
        high: Any = None,
        limits: Range | None = None,
    ) -> Array:
        """Reads `number` numbers into a new array in the machine's byte order."""
        kind, wire, native, size = arrays(code)
        offset = self.offset
        after = offset + number * size
        if after > self.end:
            self.refuse(DecodeProblem.TRUNCATED, field)
        if code == "?":
            self._expect_booleans(number, field)
        self.offset = after
        values = kind(number, wire, self.data, offset).astype(native)
        if low is not None and not (values >= low).all():
            self._refuse_outside(values, values >= low, size, field, limits or Range(low, high))
        if high is not None and not (values <= high).all():
            self._refuse_outside(values, values <= high, size, field, limits or Range(low, high))
        return values

    def _expect_booleans(self, number: int, field: str) -> None:
        raw = bytes(self.data[self.offset : self.offset + number])
        wrong = next((i for i, byte in enumerate(raw) if byte > 1), None)
        if wrong is not None:
            self.refuse(DecodeProblem.INVALID_BOOLEAN, field, self.offset + wrong)

    def _refuse_outside(
        self, values: Array, inside: Array, width: int, field: str, limits: Range
    ) -> NoReturn:
        first = int((~inside).argmax())
        why = outside(values[first].item(), limits)
        self.refuse_range(field, (len(inside) - first) * width, why)

    def octets(self, number: int, field: str = "") -> bytes:
        """Reads `number` raw bytes."""
        offset = self.offset
        after = offset + number
        if after > self.end:
            self.refuse(DecodeProblem.TRUNCATED, field)
        self.offset = after
        return bytes(self.data[offset:after])

    def enumerator(
        self,
        kind: type[_EnumT],
        number: int,
        default: _EnumT | None = None,
        field: str = "",
        width: int = 4,
    ) -> _EnumT:
        """Returns the enumerator for `number`, which was just read from `width` bytes."""
        try:
            return kind(number)
        except ValueError:
            if default is not None:
                return default
        problem, known = DecodeProblem.UNKNOWN_ENUMERATOR, ", ".join(kind.__members__)
        why = f"{number} is no {kind.__name__}; give one of {known}"
        raise DecodeError(problem, self.offset - width, field, why)

    def flags(
        self, kind: type[_FlagsT], number: int, bits: int, field: str = "", width: int = 4
    ) -> _FlagsT:
        """Returns the flags for `number`, which was just read from `width` bytes. Only the lowest
        `bits` bits may be set."""
        if number >> bits:
            self.refuse_range(field, width)
        return kind(number)

    def arm(self, selected: bool, field: str = "") -> bool:
        """Reads the flag that says whether the arm of a union follows. Raises DecodeError unless
        the flag equals `selected`."""
        start = self.offset
        if self.number("?", field) != selected:
            self.refuse(DecodeProblem.UNKNOWN_UNION_TAG, field, start)
        return selected

    def mapping(
        self,
        key: Callable[[], _KeyT],
        value: Callable[[], _ValueT],
        min_bytes_each: int,
        most: int = MAX_COUNT,
        field: str = "",
    ) -> dict[_KeyT, _ValueT]:
        """Reads a map. Its keys must be strictly ascending, so that each map has one encoding."""
        entries: dict[_KeyT, _ValueT] = {}
        last: Any = None
        for i in range(self.count(min_bytes_each, most, field)):
            start = self.offset
            name: Any = key()
            if i and not last < name:
                self.refuse(DecodeProblem.UNSORTED_MAP, field, start)
            entries[name] = value()
            last = name
        return entries

    def block(self, field: str = "") -> Decoder:
        """Skips an appendable struct, and returns a decoder for the fields of this struct only.

        Fields that remain unread in the returned decoder come from a newer writer and are ignored.
        """
        size = self.count(1, field=field)
        inner = Decoder.__new__(Decoder)
        inner.data = self.data
        inner.offset = self.offset
        inner.depth = self.depth
        self.offset = inner.end = self.offset + size
        return inner

    def enter(self, field: str = "") -> None:
        """Limits the depth of nesting. Call this method before you decode a struct that may contain
        itself, and `leave` afterwards."""
        if self.depth == MAX_DEPTH:
            self.refuse(DecodeProblem.TOO_DEEP, field)
        self.depth += 1

    def leave(self) -> None:
        self.depth -= 1

    def expect_end(self) -> None:
        if self.offset != self.end:
            self.refuse(DecodeProblem.TRAILING_BYTES)

    def refuse(
        self, problem: DecodeProblem, field: str = "", offset: int | None = None, why: str = ""
    ) -> NoReturn:
        """Raises DecodeError. The default of `offset` is the offset of the next read. `why`
        replaces the general text of `problem`."""
        raise DecodeError(problem, self.offset if offset is None else offset, field, why)
