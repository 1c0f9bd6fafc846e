"""Messages of structs that are one run of numbers are packed at once, with the same verdicts."""

from __future__ import annotations

from typing import Self

import pytest
from gecos import wire
from gecos.wire import DecodeError, DecodeProblem, EncodeError
from robcl.geometry_types import Vector

VALUE = Vector(1.0, -2.5, 3.0)
MESSAGE = wire.to_message(VALUE)


def test_packed_at_once_it_is_the_fingerprint_and_the_fields() -> None:
    assert Vector.fingerprint().to_bytes(8, "big") + wire.to_bytes(VALUE) == MESSAGE


@pytest.mark.parametrize("kind", [bytes, bytearray, memoryview])
def test_unpacked_at_once_from_any_bytes(kind: type[bytes]) -> None:
    assert wire.from_message(Vector, kind(MESSAGE)) == VALUE


def test_a_number_that_does_not_fit_is_named() -> None:
    with pytest.raises(EncodeError, match=r"Vector\.y: 'two' is not a number"):
        wire.to_message(Vector(1.0, "two", 3.0))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (MESSAGE[:5], DecodeProblem.TRUNCATED),
        (MESSAGE[:-1], DecodeProblem.TRUNCATED),
        (MESSAGE + b"\0", DecodeProblem.TRAILING_BYTES),
        (bytes(8) + MESSAGE[8:], DecodeProblem.WRONG_FINGERPRINT),
    ],
)
def test_what_is_no_such_message_is_refused_by_name(message: bytes, problem: DecodeProblem) -> None:
    with pytest.raises(DecodeError) as caught:
        wire.from_message(Vector, message)
    assert caught.value.problem is problem


def test_a_subclass_keeps_its_own_encoding() -> None:
    class Doubled(Vector):
        def encode(self, out: wire.Parts, /) -> None:
            Vector(2 * self.x, 2 * self.y, 2 * self.z).encode(out)

        @classmethod
        def decode(cls, source: wire.Decoder, /) -> Self:
            twice = Vector.decode(source)
            return cls(twice.x / 2, twice.y / 2, twice.z / 2)

    value = Doubled(1.0, 2.0, 3.0)
    message = wire.to_message(value)
    assert wire.from_message(Vector, message) == Vector(2.0, 4.0, 6.0)
    assert wire.from_message(Doubled, message) == value
