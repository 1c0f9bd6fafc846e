"""The codec under generated Python: LCM's type encoding, big-endian, fields in order.

The twin of `runtime/cpp/gecos/wire`: both accept and refuse the same bytes and call what is wrong
by the same names. Where bytes are wrong in two ways, either may be reported.

Encoding appends pieces to a list (`Parts`) that is joined once; decoding raises `DecodeError`.
numpy is imported when the first array passes, so that programs without arrays start faster.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from enum import Enum, IntEnum, IntFlag
from functools import cache
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, Self, TypeAlias, TypeVar

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[Any]

Parts: TypeAlias = list[bytes | bytearray | memoryview]

MAX_DEPTH = 16
MAX_ZERO_WIDTH = 65_536
MAX_COUNT = 2**31 - 1
MAX_TEXT = MAX_COUNT - 1

_INT32 = struct.Struct(">i")
_pack_int32 = _INT32.pack
_read_int32 = _INT32.unpack_from
_EnumT = TypeVar("_EnumT", bound=IntEnum)
_FlagsT = TypeVar("_FlagsT", bound=IntFlag)
_ElementT = TypeVar("_ElementT")
_KeyT = TypeVar("_KeyT")
_ValueT = TypeVar("_ValueT")


class DecodeProblem(Enum):
    """Why bytes were refused. Names and texts are those of the C++ side."""

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
    UNKNOWN_UNION_TAG = "the union's tag and its arms do not agree"
    OUT_OF_RANGE = "outside its declared range"
    UNSORTED_MAP = "the map's keys are not ascending"
    WRONG_FINGERPRINT = "a message of another type"
    INVALID_VALUE = "not a valid value of its type"


class DecodeError(ValueError):
    """Bytes that are not what they should be: which field, at which byte, and why."""

    def __init__(self, problem: DecodeProblem, offset: int, field: str = "") -> None:
        named = f"field '{field}' " if field else ""
        super().__init__(f"{named}at byte {offset}: {problem.value}")
        self.problem = problem
        self.offset = offset
        self.field = field

    def __reduce__(self) -> tuple[type[DecodeError], tuple[DecodeProblem, int, str]]:
        return DecodeError, (self.problem, self.offset, self.field)


class EncodeError(ValueError):
    """A value that its field cannot carry: which field, and why."""

    def __init__(self, field: str, why: str) -> None:
        super().__init__(f"{field}: {why}" if field else why)
        self.field = field
        self.why = why

    def __reduce__(self) -> tuple[type[EncodeError], tuple[str, str]]:
        return EncodeError, (self.field, self.why)


class Contents(Protocol):
    """GeneralContents: a value that encodes itself, generated or written by hand."""

    def encode(self, out: Parts, /) -> None:
        """Appends the fields."""

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        """Reads the fields back and validates them."""

    @staticmethod
    def fingerprint() -> int:
        """What lcm-gen computes for the declared layout, as an unsigned number."""


_ContentsT = TypeVar("_ContentsT", bound=Contents)


def to_bytes(value: Contents) -> bytes:
    """The fields alone."""
    out: Parts = []
    value.encode(out)
    return b"".join(out)


def from_bytes(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """The inverse of `to_bytes`; bytes left over are an error."""
    source = Decoder(data)
    value = kind.decode(source)
    source.expect_end()
    return value


def to_message(value: Contents) -> bytes:
    """An LCM message: fingerprint, then the fields."""
    out: Parts = [_fingerprint_bytes(value)]
    value.encode(out)
    return b"".join(out)


def from_message(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """The inverse of `to_message`; a message of another type is WRONG_FINGERPRINT."""
    source = Decoder(data)
    if source.octets(8) != _fingerprint_bytes(kind):
        raise DecodeError(DecodeProblem.WRONG_FINGERPRINT, 0)
    value = kind.decode(source)
    source.expect_end()
    return value


def _fingerprint_bytes(kind: Contents | type[Contents]) -> bytes:
    return (kind.fingerprint() & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "big")


class Fields:
    """A run of fixed-size members, packed and unpacked in one go.

    `codes` are those of `struct` without byte order: b B h H i I q Q f d, and ? for a boolean.
    """

    __slots__ = ("_booleans", "_codes", "_names", "_pack", "_unpack_from", "size")

    def __init__(self, codes: str, names: Sequence[str]) -> None:
        if len(codes) != len(names):
            raise ValueError(f"{len(codes)} codes for {len(names)} names: {codes!r}, {names!r}")
        self._codes = codes
        self._names = tuple(names)
        self._booleans = tuple(i for i, code in enumerate(codes) if code == "?")
        self._pack = struct.Struct(">" + codes).pack
        reader = struct.Struct(">" + codes.replace("?", "B"))
        self._unpack_from = reader.unpack_from
        self.size = reader.size

    def pack(self, *values: Any) -> bytes:
        try:
            return self._pack(*values)
        except (struct.error, OverflowError, TypeError):
            raise self._unfit(values) from None

    def unpack(self, source: Decoder) -> tuple[Any, ...]:
        offset = source.offset
        after = offset + self.size
        if after > source.end:
            self._refuse_truncated(source)
        source.offset = after
        values = self._unpack_from(source.data, offset)
        if self._booleans:
            return self._with_booleans(values, offset)
        return values

    def _with_booleans(self, values: tuple[Any, ...], offset: int) -> tuple[Any, ...]:
        changed = list(values)
        for i in self._booleans:
            if values[i] > 1:
                at = offset + struct.calcsize(">" + self._codes[:i])
                raise DecodeError(DecodeProblem.INVALID_BOOLEAN, at, self._names[i])
            changed[i] = values[i] == 1
        return tuple(changed)

    def _refuse_truncated(self, source: Decoder) -> NoReturn:
        for code, name in zip(self._codes, self._names, strict=True):
            if source.remaining < struct.calcsize(">" + code):
                source.refuse(DecodeProblem.TRUNCATED, name)
            source.number(code, name)  # an invalid boolean before the end is reported first
        raise AssertionError("a truncated run has a first field that does not fit")

    def _unfit(self, values: tuple[Any, ...]) -> EncodeError | TypeError:
        if len(values) != len(self._codes):
            return TypeError(f"{len(self._codes)} values expected, {len(values)} given")
        for code, name, value in zip(self._codes, self._names, values, strict=True):
            try:
                struct.pack(">" + code, value)
            except (struct.error, OverflowError, TypeError):
                return EncodeError(name, f"{value!r} is not {_CODE_MEANING[code]}")
        raise AssertionError("a run that cannot be packed has a value that cannot")


_CODE_MEANING = {
    "?": "a boolean",
    "b": "a whole number from -128 to 127",
    "B": "a whole number from 0 to 255",
    "h": "a whole number from -32768 to 32767",
    "H": "a whole number from 0 to 65535",
    "i": "a whole number from -2147483648 to 2147483647",
    "I": "a whole number from 0 to 4294967295",
    "q": "a whole number from -2**63 to 2**63 - 1",
    "Q": "a whole number from 0 to 2**64 - 1",
    "f": "a number of single precision",
    "d": "a number",
}
_WRITERS = {code: struct.Struct(">" + code) for code in _CODE_MEANING}
_READERS = {code: struct.Struct(">" + code.replace("?", "B")) for code in _CODE_MEANING}


@cache
def _dtypes(code: str) -> tuple[np.dtype[Any], np.dtype[Any]]:
    """In the wire's byte order, and in the machine's."""
    import numpy as np

    wire = np.dtype(">" + code)
    return wire, wire.newbyteorder("=")


# Encoding ---------------------------------------------------------------------------------------


def count(number: int, most: int = MAX_COUNT, field: str = "") -> bytes:
    """How many elements follow."""
    if number > most:
        raise EncodeError(field, f"{number} elements, at most {most} are allowed")
    return _pack_int32(number)


def string(text: str, most: int = MAX_COUNT - 1, field: str = "") -> bytes:
    """Length with NUL, UTF-8, NUL. `most` counts bytes of UTF-8 without the NUL."""
    try:
        raw = text.encode()
    except UnicodeEncodeError as error:
        raise EncodeError(field, f"{text!r} cannot be UTF-8: {error.reason}") from None
    size = len(raw)
    if size > most:
        raise EncodeError(field, f"{size} bytes of text, at most {most} are allowed")
    if b"\0" in raw:
        raise EncodeError(field, f"{text!r} contains NUL")
    return _pack_int32(size + 1) + raw + b"\0"


def array(values: npt.ArrayLike, code: str, field: str = "") -> memoryview:
    """Numbers in big-endian order, without a count, ready to be joined. `code` as for `Fields`.

    Refuses what would change the numbers; only double to single precision may round.
    """
    import numpy as np

    given = np.asarray(values)
    wanted, native = _dtypes(code)
    if given.dtype == native or given.size == 0 or np.can_cast(given.dtype, wanted, "safe"):
        return given.astype(wanted, order="C").data
    if given.dtype.kind in "iuf" and wanted.kind == "f":
        return given.astype(wanted, order="C").data
    if given.dtype.kind in "iu" and wanted.kind in "iu":
        limits = np.iinfo(wanted)
        low, high = int(given.min()), int(given.max())
        if limits.min <= low and high <= limits.max:
            return given.astype(wanted, order="C").data
        worst = low if low < limits.min else high
        raise EncodeError(field, f"{worst} is not {_CODE_MEANING[code]}")
    raise EncodeError(field, f"an array of {given.dtype} where each is {_CODE_MEANING[code]}")


def block(parts: Parts) -> bytes:
    """An appendable struct: its size in bytes, then its fields."""
    fields = b"".join(parts)
    return _pack_int32(len(fields)) + fields


def put_block(value: Contents, out: Parts) -> None:
    """An appendable value in its block."""
    parts: Parts = []
    value.encode(parts)
    out.append(block(parts))


def number(value: Any, code: str, field: str = "") -> bytes:
    """One value of a code as for `Fields`."""
    try:
        return _WRITERS[code].pack(value)
    except (struct.error, OverflowError, TypeError):
        raise EncodeError(field, f"{value!r} is not {_CODE_MEANING[code]}") from None


def char(letter: str, field: str = "") -> bytes:
    """One character of Latin-1, a byte."""
    try:
        raw = letter.encode("latin-1")
    except UnicodeEncodeError:
        raw = b""
    if len(raw) != 1:
        raise EncodeError(field, f"{letter!r} is not one character of Latin-1")
    return raw


def numbers(
    values: npt.ArrayLike, code: str, most: int, field: str = "", low: Any = None, high: Any = None
) -> Parts:
    """A sequence of numbers: its count, then the numbers, each within `low` and `high`."""
    import numpy as np

    given = np.asarray(values)
    if given.ndim != 1:
        raise EncodeError(field, f"an array of {given.ndim} dimensions where a sequence has one")
    _expect_within(given, low, high, field)
    return [count(len(given), most, field), array(given, code, field)]


def fixed(
    values: npt.ArrayLike,
    code: str,
    shape: tuple[int, ...],
    field: str = "",
    low: Any = None,
    high: Any = None,
) -> memoryview:
    """An array of numbers of a given shape, each within `low` and `high`."""
    import numpy as np

    given = np.asarray(values)
    if given.shape != shape:
        raise EncodeError(field, f"an array of shape {given.shape} where {shape} is declared")
    _expect_within(given, low, high, field)
    return array(given, code, field)


def _expect_within(given: Array, low: Any, high: Any, field: str) -> None:
    if low is None and high is None:
        return
    import numpy as np

    outside = np.zeros(given.shape, bool)
    if low is not None:
        outside |= ~(given >= low)
    if high is not None:
        outside |= ~(given <= high)
    if outside.any():
        shown = f"[{'-inf' if low is None else low}, {'inf' if high is None else high}]"
        raise out_of_range(field, given[outside].flat[0].item(), shown)


def octets(raw: bytes, most: int, field: str = "") -> Parts:
    """A sequence of bytes: its count, then the bytes."""
    return [count(len(raw), most, field), bytes(raw)]


def fixed_octets(raw: bytes, size: int, field: str = "") -> bytes:
    if len(raw) != size:
        raise EncodeError(field, f"{len(raw)} bytes where {size} are declared")
    return bytes(raw)


def exactly(values: Sequence[_ElementT], size: int, field: str = "") -> Sequence[_ElementT]:
    """`values`, which are refused unless there are so many."""
    if len(values) != size:
        raise EncodeError(field, f"{len(values)} elements where {size} are declared")
    return values


def out_of_range(field: str, value: object, limits: str) -> EncodeError:
    return EncodeError(field, f"{value} is outside {limits}")


def signed(bits: int, width: int) -> int:
    """The number that `width` bits are in two's complement."""
    return bits - (1 << width) if bits >> (width - 1) else bits


def first(entry: tuple[Any, Any]) -> Any:
    """Key by which the entries of a map are sorted."""
    return entry[0]


def zeros(code: str, *shape: int) -> Array:
    """An array as a new value has it."""
    import numpy as np

    return np.zeros(shape, _dtypes(code)[1])


def same(left: Any, right: Any) -> bool:
    """`==` for values that hold arrays."""
    if isinstance(left, list) or isinstance(right, list):
        sized = hasattr(left, "__len__") and hasattr(right, "__len__")
        return sized and len(left) == len(right) and all(map(same, left, right))
    if isinstance(left, dict) and isinstance(right, dict):
        return left.keys() == right.keys() and all(same(left[key], right[key]) for key in left)
    if left is None or right is None:
        return left is right
    equal = left == right
    if hasattr(equal, "all"):
        return bool(equal.all()) and left.shape == right.shape
    return bool(equal)


# Decoding ---------------------------------------------------------------------------------------


class Decoder:
    """Reads from bytes that nobody vouches for; the first fault raises DecodeError.

    No count is believed before the bytes that it promises are there.
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
        """One value of a code as for `Fields`."""
        reader = _READERS[code]
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
        """`most` counts bytes of UTF-8 without the NUL."""
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
        """What is wrong with the string at `offset`, in the order in which C++ looks."""
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
        """A count of elements of at least so many bytes each, which are there."""
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

    def ranged(self, code: str, low: Any, high: Any, field: str = "") -> Any:
        """One value of a code as for `Fields`, within `low` and `high`; None leaves a side open."""
        value = self.number(code, field)
        if (low is not None and not value >= low) or (high is not None and not value <= high):
            self.refuse_range(field, _READERS[code].size)
        return value

    def refuse_range(self, field: str, width: int) -> NoReturn:
        """Refuses a number that begins `width` bytes before what is read next."""
        raise DecodeError(DecodeProblem.OUT_OF_RANGE, self.offset - width, field)

    def array(
        self, code: str, number: int, field: str = "", low: Any = None, high: Any = None
    ) -> Array:
        """So many numbers, in an array of its own in the machine's byte order."""
        import numpy as np

        kind, native = _dtypes(code)
        offset = self.offset
        after = offset + number * kind.itemsize
        if after > self.end:
            self.refuse(DecodeProblem.TRUNCATED, field)
        if code == "?":
            raw = np.frombuffer(self.data, np.uint8, number, offset)
            if number and int(raw.max()) > 1:
                at = offset + int((raw > 1).argmax())
                raise DecodeError(DecodeProblem.INVALID_BOOLEAN, at, field)
        self.offset = after
        values = np.frombuffer(self.data, kind, number, offset).astype(native)
        if low is not None and not (values >= low).all():
            self._refuse_outside(values >= low, kind.itemsize, field)
        if high is not None and not (values <= high).all():
            self._refuse_outside(values <= high, kind.itemsize, field)
        return values

    def _refuse_outside(self, inside: Array, width: int, field: str) -> NoReturn:
        self.refuse_range(field, (len(inside) - int((~inside).argmax())) * width)

    def octets(self, number: int, field: str = "") -> bytes:
        """So many bytes as they are."""
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
        """The enumerator of a number that was just read with `width` bytes."""
        try:
            return kind(number)
        except ValueError:
            if default is not None:
                return default
        raise DecodeError(DecodeProblem.UNKNOWN_ENUMERATOR, self.offset - width, field)

    def flags(
        self, kind: type[_FlagsT], number: int, bits: int, field: str = "", width: int = 4
    ) -> _FlagsT:
        """The flags of a number that was just read with `width` bytes; `bits` may be set."""
        if number >> bits:
            self.refuse_range(field, width)
        return kind(number)

    def arm(self, selected: bool, field: str = "") -> bool:
        """Whether an arm of a union is there, which it must be exactly when it is selected."""
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
        """Entries whose keys ascend strictly: a map has one encoding."""
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
        """Steps over an appendable struct and returns a decoder of its fields alone.

        What that one leaves unread is a newer writer's and is ignored.
        """
        size = self.count(1, field=field)
        inner = Decoder.__new__(Decoder)
        inner.data = self.data
        inner.offset = self.offset
        inner.depth = self.depth
        self.offset = inner.end = self.offset + size
        return inner

    def enter(self, field: str = "") -> None:
        """Before a nested struct; `leave` after it."""
        if self.depth == MAX_DEPTH:
            self.refuse(DecodeProblem.TOO_DEEP, field)
        self.depth += 1

    def leave(self) -> None:
        self.depth -= 1

    def expect_end(self) -> None:
        if self.offset != self.end:
            self.refuse(DecodeProblem.TRAILING_BYTES)

    def refuse(
        self, problem: DecodeProblem, field: str = "", offset: int | None = None
    ) -> NoReturn:
        """Raises; the offset is where the next read would start unless it is given."""
        raise DecodeError(problem, self.offset if offset is None else offset, field)
