"""Values that encode themselves, and what they become: fields, blocks, LCM messages."""

from __future__ import annotations

import struct
from typing import Protocol, Self, TypeVar

from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, block
from gecos.wire.errors import DecodeError, DecodeProblem


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
    whole = getattr(value, "_gecos_message", None)
    if whole is not None:  # a struct that is one run of numbers
        try:
            packed: bytes = whole()
            return packed
        except (struct.error, OverflowError, TypeError):
            pass  # what does not fit is named below
    out: Parts = [_fingerprint_bytes(value)]
    value.encode(out)
    return b"".join(out)


def from_message(kind: type[_ContentsT], data: bytes | bytearray | memoryview) -> _ContentsT:
    """The inverse of `to_message`; a message of another type is WRONG_FINGERPRINT."""
    plain = getattr(kind, "_gecos_plain", None)
    if plain is not None and len(data) == plain[0].size + 8 and type(data) is bytes:
        fingerprint, *values = plain[0].unpack_message(data)
        if fingerprint == plain[1]:
            return kind(*values)
    source = Decoder(data)
    if source.octets(8) != _fingerprint_bytes(kind):
        raise DecodeError(DecodeProblem.WRONG_FINGERPRINT, 0)
    value = kind.decode(source)
    source.expect_end()
    return value


def _fingerprint_bytes(kind: Contents | type[Contents]) -> bytes:
    return (kind.fingerprint() & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "big")


def put_block(value: Contents, out: Parts) -> None:
    """An appendable value in its block."""
    parts: Parts = []
    value.encode(parts)
    out.append(block(parts))
