"""Encodes the parts of a value. Each function returns the bytes of one part; the caller joins all
parts once at the end."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from gecos.wire.codes import CODE_MEANING, MAX_COUNT, WRITERS, arrays
from gecos.wire.errors import (
    HIDDEN,
    EncodeError,
    RangeError,
    brief,
    expect,
    expect_boolean,
    unfit,
)
from gecos.wire.units import Range
from gecos.wire.values import as_array, first

if TYPE_CHECKING:
    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[Any]


Parts: TypeAlias = list[bytes | bytearray | memoryview]

_ElementT = TypeVar("_ElementT")
_KeyT = TypeVar("_KeyT")
_pack_int32 = struct.Struct(">i").pack


def count(number: int, most: int = MAX_COUNT, field: str = "") -> bytes:
    """Encodes the count of the elements that follow."""
    if number > most:
        raise EncodeError(field, f"{number} elements, at most {most} are allowed")
    return _pack_int32(number)


def counted(values: Any, most: int = MAX_COUNT, field: str = "") -> bytes:
    """Encodes the number of elements of `values`. The caller encodes the elements."""
    return count(_length(values, field), most, field)


def _length(values: Any, field: str) -> int:
    try:
        return len(values)
    except TypeError:
        raise EncodeError(field, f"{values!r} is not a list or an array") from None


def entries(values: Mapping[_KeyT, _ElementT], field: str = "") -> list[tuple[_KeyT, _ElementT]]:
    """Returns the entries of a map in the order of its keys, so that each map has only one
    encoding."""
    expect(values, Mapping, field)
    try:
        return sorted(values.items(), key=first)
    except TypeError:
        raise EncodeError(field, "the keys of the map are not all of one type") from None


def string(text: str, most: int = MAX_COUNT - 1, field: str = "") -> bytes:
    """Encodes a string: its size with NUL, the UTF-8 bytes, and NUL. `most` is the limit in bytes
    without the NUL."""
    try:
        raw = text.encode()
    except UnicodeEncodeError as error:
        raise EncodeError(field, f"{text!r} cannot be encoded as UTF-8: {error.reason}") from None
    except AttributeError:
        raise EncodeError(field, f"{text!r} is not a string") from None
    size = len(raw)
    if size > most:
        raise EncodeError(field, f"{size} bytes of text, at most {most} are allowed")
    if b"\0" in raw:
        raise EncodeError(field, f"{text!r} contains NUL")
    return _pack_int32(size + 1) + raw + b"\0"


def secret_string(text: str, most: int = MAX_COUNT - 1, field: str = "") -> bytes:
    """Encodes a string that must not appear in any error message."""
    try:
        return string(text, most, field)
    except EncodeError as error:
        raise EncodeError(field, error.why.replace(repr(text), HIDDEN)) from None


def array(values: npt.ArrayLike, code: str, field: str = "") -> memoryview:
    """Encodes an array of numbers as big-endian, without a count. `code` is a number code as in
    `Fields`.

    Refuses a conversion that changes a number; only a conversion to floating point may round, but
    not to infinity. A bytes object counts as an array with the code `B`.
    """
    kind, wanted, native, _ = arrays(code)
    if type(values) is kind and values.dtype is native:
        swapped: Any = values.astype(wanted, "C")
    else:
        swapped = _swapped(_fitting(values, code, field), code, field)
    return swapped  # type: ignore[no-any-return]  # an array is a buffer, which `join` accepts


def _swapped(given: Array, code: str, field: str) -> Array:
    """Returns `given` as big-endian numbers of `code`. Raises EncodeError if a finite number is too
    large for a shorter floating-point number, which would be infinite."""
    import numpy as np

    wanted = arrays(code)[1]
    if given.dtype.kind != "f" or given.dtype.itemsize <= wanted.itemsize:
        return given.astype(wanted, "C")
    with np.errstate(over="ignore"):
        swapped = given.astype(wanted, "C")
    too_large = np.isinf(swapped) & np.isfinite(given)
    if too_large.any():
        index, name = _first_of(too_large, field)
        meaning = f"not {CODE_MEANING[code]}" if code == "f" else "too large; give a smaller number"
        raise EncodeError(name, f"{given[index]} is {meaning}")
    return swapped


def _fitting(values: npt.ArrayLike, code: str, field: str) -> Array:
    """Returns `values` as an array. Raises EncodeError unless `code` can represent all numbers."""
    import numpy as np

    given = _as_array(values, code, field)
    wanted = arrays(code)[1]
    if given.size == 0 or np.can_cast(given.dtype, wanted, "safe"):
        return given
    if given.dtype.kind in "iuf" and wanted.kind == "f":
        return given
    if given.dtype.kind in "iu" and wanted.kind in "iu":
        limits = np.iinfo(wanted)
        low, high = int(given.min()), int(given.max())
        if limits.min <= low and high <= limits.max:
            return given
        worst = low if low < limits.min else high
        raise EncodeError(field, f"{worst} is not {CODE_MEANING[code]}")
    raise EncodeError(
        field, f"an array of {given.dtype}, but each element must be {CODE_MEANING[code]}"
    )


def block(parts: Parts) -> bytes:
    """Encodes an appendable struct: its size in bytes, then its fields."""
    fields = b"".join(parts)
    return _pack_int32(len(fields)) + fields


def number(value: Any, code: str, field: str = "") -> bytes:
    """Encodes one number. `code` is a number code as in `Fields`."""
    if code == "?":
        expect_boolean(value, field)
    try:
        return WRITERS[code].pack(value)
    except (struct.error, OverflowError, TypeError) as error:
        too_large = isinstance(error, OverflowError) and code in "fd"
        why = f"{brief(value)} is too large; give a smaller number"
        raise EncodeError(field, why if too_large else unfit(value, CODE_MEANING[code])) from None


def char(letter: str, field: str = "") -> bytes:
    """Encodes one character of Latin-1 as a byte."""
    try:
        raw = letter.encode("latin-1")
    except (UnicodeEncodeError, AttributeError):
        raw = b""
    if len(raw) != 1:
        raise EncodeError(field, f"{letter!r} is not one character of Latin-1")
    return raw


def numbers(
    values: npt.ArrayLike,
    code: str,
    most: int,
    field: str = "",
    low: Any = None,
    high: Any = None,
    limits: Range | None = None,
) -> Parts:
    """Encodes a sequence of numbers: its count, then the numbers. Each number must be from `low` to
    `high`. `limits` is this range as error messages show it."""
    kind, wanted, native, _ = arrays(code)
    if (  # the usual case, handled fast
        type(values) is kind
        and (values.dtype is native and values.ndim == 1 and low is high is None)
        and (size := len(values)) <= most
    ):
        swapped: Any = values.astype(wanted)
        return [_pack_int32(size), swapped]
    given = _as_array(values, code, field)
    if given.ndim != 1:
        raise EncodeError(field, f"the array has {given.ndim} dimensions, but a sequence has one")
    number = count(len(given), most, field)
    return [number, _array_within(given, code, low, high, field, limits)]


def fixed(
    values: npt.ArrayLike,
    code: str,
    shape: tuple[int, ...],
    field: str = "",
    low: Any = None,
    high: Any = None,
    limits: Range | None = None,
) -> memoryview:
    """Encodes an array of numbers of shape `shape`. Each number must be from `low` to `high`.
    `limits` is this range as error messages show it."""
    given = _as_array(values, code, field)
    if given.shape != shape:
        raise EncodeError(
            field, f"the array has shape {given.shape}; give an array of the declared shape {shape}"
        )
    return _array_within(given, code, low, high, field, limits)


def _as_array(values: npt.ArrayLike, code: str, field: str) -> Array:
    try:
        return as_array(values, code)
    except ValueError:  # numpy makes no array of lists of different lengths
        raise EncodeError(
            field, "the lists in this field differ in length; give numbers, or lists of one length"
        ) from None


def _array_within(
    given: Array, code: str, low: Any, high: Any, field: str, limits: Range | None
) -> memoryview:
    numbers = array(given, code, field)  # the type is checked before the limits, as for one number
    if low is not None or high is not None:
        _expect_within(given, low, high, field, limits or Range(low, high))
    return numbers


def _expect_within(given: Array, low: Any, high: Any, field: str, limits: Range) -> None:
    import numpy as np

    outside = np.zeros(given.shape, bool)
    if low is not None:
        outside |= ~(given >= low)
    if high is not None:
        outside |= ~(given <= high)
    if outside.any():
        index, name = _first_of(outside, field)
        raise RangeError(name, given[index].item(), limits)


def _first_of(flags: Array, field: str) -> tuple[tuple[int, ...], str]:
    """Returns the index of the first element of `flags` that is True, and the name of this element
    in the array `field`, for example "field[2][0]"."""
    import numpy as np

    index = tuple(int(each) for each in np.unravel_index(int(flags.argmax()), flags.shape))
    return index, field + "".join(f"[{each}]" for each in index)


def octets(raw: bytes, most: int, field: str = "") -> Parts:
    """Encodes a sequence of bytes: its count, then the bytes."""
    given = _as_bytes(raw, field)
    return [count(len(given), most, field), given]


def fixed_octets(raw: bytes, size: int, field: str = "") -> bytes:
    given = _as_bytes(raw, field)
    if len(given) != size:
        raise EncodeError(field, f"{len(given)} bytes, but {size} are declared")
    return given


def _as_bytes(raw: Any, field: str) -> bytes:
    """Converts a buffer of bytes, or a list or tuple of numbers from 0 to 255, to a bytes
    object."""
    if type(raw) is bytes:
        return raw
    try:
        if isinstance(raw, list | tuple):
            return bytes(raw)
        lent = memoryview(raw)
    except (TypeError, ValueError):
        raise EncodeError(field, f"{raw!r} is not bytes") from None
    if lent.itemsize != 1 or lent.ndim != 1:
        raise EncodeError(field, f"{raw!r} is not bytes")
    return lent.tobytes()


def exactly(values: Sequence[_ElementT], size: int, field: str = "") -> Sequence[_ElementT]:
    """Returns `values`. Raises EncodeError unless `values` has `size` elements."""
    number = _length(values, field)
    if number != size:
        raise EncodeError(field, f"{number} elements, but {size} are declared")
    return values
