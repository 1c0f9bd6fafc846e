"""Values that encode themselves: as bare fields, as blocks or as LCM messages."""

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
        """Appends the encoded fields to `out`."""


class Contents(Encodes, Protocol):
    """A value that encodes and decodes itself. Its type is generated or written by hand. In C++,
    the concept GeneralContents corresponds to this protocol."""

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        """Decodes the fields and validates them."""

    @staticmethod
    def fingerprint() -> int:
        """The fingerprint that lcm-gen computes for the declared layout, as an unsigned number."""


_ContentsT = TypeVar("_ContentsT", bound=Contents)


@accelerated
def to_bytes(value: Contents) -> bytes:
    """Encodes the fields without a fingerprint or a size."""
    out: Parts = []
    value.encode(out)
    return b"".join(out)


@accelerated
def from_bytes(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """Decodes the bytes that `to_bytes` returns. Raises TRAILING_BYTES if bytes are left over."""
    source = Decoder(data)
    value = kind.decode(source)
    source.expect_end()
    return value


@accelerated
def to_message(value: Contents) -> bytes:
    """Encodes an LCM message: the fingerprint, then the fields."""
    out: Parts = [_fingerprint_bytes(type(value))]
    value.encode(out)
    return b"".join(out)


@accelerated
def from_message(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """Decodes the message that `to_message` returns. Raises WRONG_FINGERPRINT for a message of
    another type."""
    source = Decoder(data)
    if source.data[:8] != _fingerprint_bytes(kind):
        source.octets(8)  # raises TRUNCATED if there are fewer than 8 bytes
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
    """Appends a nested value to `out`. The value must be an instance of `kind`."""
    expect(value, kind, field)
    value.encode(out)


@accelerated
def put_block(value: Encodes, kind: type, out: Parts, field: str) -> None:
    """Appends a nested value of the appendable type `kind` to `out`, in a block."""
    expect(value, kind, field)
    parts: Parts = []
    value.encode(parts)
    out.append(block(parts))
