"""Values that encode themselves, and what they become: fields, blocks, LCM messages."""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any, Protocol, Self, TypeVar

from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, block
from gecos.wire.errors import DecodeError, DecodeProblem, expect
from gecos.wire.fields import Fields


class Encodes(Protocol):
    """What can stand inside another value."""

    def encode(self, out: Parts, /) -> None:
        """Appends the fields."""


class Contents(Encodes, Protocol):
    """GeneralContents: a value that encodes itself, generated or written by hand."""

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        """Reads the fields back and validates them."""

    @staticmethod
    def fingerprint() -> int:
        """What lcm-gen computes for the declared layout, as an unsigned number."""


_ContentsT = TypeVar("_ContentsT", bound=Contents)
_KindT = TypeVar("_KindT", bound=type[Any])

# Of structs that are one run of numbers: how a message is packed, unpacked and known.
_one_run: dict[type, tuple[Callable[[Any], bytes], Callable[[Any], tuple[Any, ...]], int]] = {}


def one_run(run: Fields) -> Callable[[_KindT], _KindT]:
    """Tells of a generated struct that `run` is all of it, in the order of its constructor, and
    that nothing in it needs a check: its messages are packed and unpacked in one go."""

    def tell(kind: _KindT) -> _KindT:
        _one_run[kind] = (kind._gecos_message, run.unpack_message, kind.fingerprint())
        return kind

    return tell


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
    whole = _one_run.get(type(value))
    if whole is not None:
        try:
            return whole[0](value)
        except (struct.error, OverflowError, TypeError):
            pass  # what does not fit is named below
    out: Parts = [_fingerprint_bytes(type(value))]
    value.encode(out)
    return b"".join(out)


def from_message(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """The inverse of `to_message`; a message of another type is WRONG_FINGERPRINT."""
    whole = _one_run.get(kind)
    if whole is not None:
        _, unpack, fingerprint = whole
        try:
            values = unpack(data)
        except (struct.error, BufferError):
            pass  # what is wrong is named below
        else:
            if values[0] == fingerprint:
                return kind(*values[1:])
    source = Decoder(data)
    if source.data[:8] != _fingerprint_bytes(kind):
        source.octets(8)  # are they there?
        raise DecodeError(DecodeProblem.WRONG_FINGERPRINT, 0)
    source.offset = 8
    value = kind.decode(source)
    source.expect_end()
    return value


@cache
def _fingerprint_bytes(kind: type[Contents]) -> bytes:
    return (kind.fingerprint() & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "big")


def put(value: Encodes, kind: type, out: Parts, field: str) -> None:
    """A value inside another, of the type that `field` has."""
    expect(value, kind, field)
    value.encode(out)


def put_block(value: Encodes, kind: type, out: Parts, field: str) -> None:
    """The same of an appendable one, in its block."""
    expect(value, kind, field)
    parts: Parts = []
    value.encode(parts)
    out.append(block(parts))
