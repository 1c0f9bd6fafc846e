"""Values that encode themselves, as bare fields, blocks or LCM messages."""

from __future__ import annotations

from functools import cache
from typing import Protocol, Self, TypeVar

from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, block
from gecos.wire.errors import DecodeError, DecodeProblem, expect
from gecos.wire.plans import accelerated


class Encodes(Protocol):
    """A type whose values may be members of another value."""

    def encode(self, out: Parts, /) -> None:
        """Appends the fields."""


class Contents(Encodes, Protocol):
    """GeneralContents: a value that encodes itself, generated or written by hand."""

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        """Reads the fields back and validates them."""

    @staticmethod
    def fingerprint() -> int:
        """The fingerprint that lcm-gen computes for the declared layout, as an unsigned number."""


_ContentsT = TypeVar("_ContentsT", bound=Contents)


@accelerated
def to_bytes(value: Contents) -> bytes:
    """Encodes the fields alone."""
    out: Parts = []
    value.encode(out)
    return b"".join(out)


@accelerated
def from_bytes(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """The inverse of `to_bytes`; bytes left over are an error."""
    source = Decoder(data)
    value = kind.decode(source)
    source.expect_end()
    return value


@accelerated
def to_message(value: Contents) -> bytes:
    """An LCM message: fingerprint, then the fields."""
    out: Parts = [_fingerprint_bytes(type(value))]
    value.encode(out)
    return b"".join(out)


@accelerated
def from_message(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """The inverse of `to_message`; a message of another type is WRONG_FINGERPRINT."""
    source = Decoder(data)
    if source.data[:8] != _fingerprint_bytes(kind):
        source.octets(8)  # too few bytes are TRUNCATED
        raise DecodeError(DecodeProblem.WRONG_FINGERPRINT, 0)
    source.offset = 8
    value = kind.decode(source)
    source.expect_end()
    return value


@cache
def _fingerprint_bytes(kind: type[Contents]) -> bytes:
    return (kind.fingerprint() & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "big")


@accelerated
def put(value: Encodes, kind: type, out: Parts, field: str) -> None:
    """Appends a nested value, which must be a `kind`."""
    expect(value, kind, field)
    value.encode(out)


@accelerated
def put_block(value: Encodes, kind: type, out: Parts, field: str) -> None:
    """Appends a nested value of an appendable type in a block; it must be a `kind`."""
    expect(value, kind, field)
    parts: Parts = []
    value.encode(parts)
    out.append(block(parts))
