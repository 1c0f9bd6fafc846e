"""What generated codecs are written in: whole sequences, arrays, maps, enumerations and ranges."""

from __future__ import annotations

import pickle
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, Self

import numpy as np
import pytest
from gecos import wire
from gecos.wire import DecodeError, DecodeProblem, Decoder, EncodeError, Parts, layout
from gecos.wire.kinds import Kind
from gecos.wire.members import Arguments


class Axes(IntFlag):
    X = 1
    Y = 2
    Z = 4


@dataclass(slots=True)
class Byte:
    value: int = 0

    def encode(self, out: Parts) -> None:
        out.append(wire.number(self.value, "B", "Byte.value"))

    @classmethod
    def decode(cls, source: Decoder) -> Self:
        return cls(source.number("B", "Byte.value"))

    @staticmethod
    def fingerprint() -> int:
        return 1


def refusal(data: bytes, read: Callable[[Decoder], Any]) -> tuple[DecodeProblem, int, str]:
    with pytest.raises(DecodeError) as caught:
        read(Decoder(data))
    return caught.value.problem, caught.value.offset, caught.value.field


def test_numbers_are_a_count_and_the_numbers() -> None:
    assert b"".join(wire.numbers([1, 2], "h", 4)) == struct.pack(">ihh", 2, 1, 2)
    with pytest.raises(EncodeError, match="v: 5 elements, at most 4 are allowed"):
        wire.numbers(range(5), "h", 4, "v")
    with pytest.raises(EncodeError, match="v: the array has 2 dimensions, but a sequence has one"):
        wire.numbers(np.eye(2), "d", 4, "v")
    with pytest.raises(EncodeError, match="v: the lists in this field differ in length"):
        wire.numbers([[1.0, 2.0], [3.0]], "d", 4, "v")
    with pytest.raises(EncodeError, match="v: the lists in this field differ in length"):
        wire.fixed([[1.0, 2.0], [3.0]], "d", (2, 2), "v")


def test_every_element_of_a_sequence_is_held_to_its_range() -> None:
    assert b"".join(wire.numbers([0.0, 1.0], "d", 4, "v", 0.0, 1.0))[:4] == b"\0\0\0\2"
    with pytest.raises(EncodeError, match=r"v\[1\]: 1.5 is outside \[0.0, 1.0\]"):
        wire.numbers([0.5, 1.5], "d", 4, "v", 0.0, 1.0)
    with pytest.raises(EncodeError, match=r"v\[0\]: nan is outside \[0.0, inf\]"):
        wire.numbers([np.nan], "d", 4, "v", 0.0)


def test_an_array_has_its_declared_shape() -> None:
    assert bytes(wire.fixed(np.eye(2), "d", (2, 2))) == struct.pack(">4d", 1, 0, 0, 1)
    with pytest.raises(
        EncodeError,
        match=r"v: the array has shape \(3,\); give an array of the declared shape \(2, 2\)",
    ):
        wire.fixed([1, 2, 3], "d", (2, 2), "v")
    with pytest.raises(EncodeError, match=r"v\[1\]: -1 is outside \[0, 9\]"):
        wire.fixed([1, -1], "i", (2,), "v", 0, 9)
    with pytest.raises(EncodeError, match=r"v\[1\]\[0\]: -1 is outside \[0, 9\]"):
        wire.fixed([[1, 1], [-1, -1]], "i", (2, 2), "v", 0, 9)


def test_an_array_outside_its_range_says_which_element() -> None:
    data = struct.pack(">4h", 1, 2, 30, 4)
    assert Decoder(data).array("h", 4, "v", 1, 30).tolist() == [1, 2, 30, 4]
    read_high = refusal(data, lambda source: source.array("h", 4, "v", None, 10))
    assert read_high == (DecodeProblem.OUT_OF_RANGE, 4, "v")
    read_low = refusal(data, lambda source: source.array("h", 4, "v", 2, None))
    assert read_low == (DecodeProblem.OUT_OF_RANGE, 0, "v")
    not_a_number = struct.pack(">d", np.nan)
    assert refusal(not_a_number, lambda source: source.array("d", 1, "v", 0.0, 1.0)) == (
        DecodeProblem.OUT_OF_RANGE,
        0,
        "v",
    )


def test_a_range_error_names_unit_and_value() -> None:
    turned = layout.ranged("d", -2.0, 2.0, "rad")
    with pytest.raises(EncodeError) as sent:
        turned.put(90.0, [], "v")
    assert str(sent.value) == "v: 90.0 is outside [-2.0, 2.0] rad; is the value in degrees?"
    with pytest.raises(DecodeError) as received:
        turned.take(Decoder(struct.pack(">d", 3.0)), "v")
    assert (
        str(received.value)
        == "field 'v' at byte 0: 3.0 is outside [-2.0, 2.0] rad; give at most 2.0 rad"
    )
    assert str(pickle.loads(pickle.dumps(received.value))) == str(received.value)
    turns = layout.numbers("d", low=-2.0, high=2.0, unit="rad")
    with pytest.raises(DecodeError, match=r"at byte 4: 90.0 is outside \[-2.0, 2.0\] rad; is the"):
        turns.take(Decoder(struct.pack(">id", 1, 90.0)), "v")  # type: ignore[union-attr]
    octets = layout.octets(low=2, high=9, unit="m")
    with pytest.raises(DecodeError, match=r"byte 5: 1 is outside \[2, 9\] m; give at least 2 m$"):
        octets.take(Decoder(struct.pack(">iBB", 2, 2, 1)), "v")


def test_a_number_is_held_to_its_range() -> None:
    data = struct.pack(">bd", 0, 1.5)
    source = Decoder(data)
    assert source.ranged("b", 0, None) == 0
    assert source.ranged("d", None, 1.5) == 1.5
    assert refusal(data[1:], lambda source: source.ranged("d", 0.0, 1.0, "v")) == (
        DecodeProblem.OUT_OF_RANGE,
        0,
        "v",
    )


def test_bytes_keep_their_number() -> None:
    assert b"".join(wire.octets(b"abc", 3)) == b"\0\0\0\3abc"
    assert wire.fixed_octets(bytearray(b"ab"), 2) == b"ab"
    with pytest.raises(EncodeError, match="v: 4 elements, at most 3"):
        wire.octets(b"abcd", 3, "v")
    with pytest.raises(EncodeError, match="v: 1 bytes, but 2 are declared"):
        wire.fixed_octets(b"a", 2, "v")
    assert wire.exactly(["a"], 1) == ["a"]
    with pytest.raises(EncodeError, match="v: 1 elements, but 2 are declared"):
        wire.exactly(["a"], 2, "v")


def test_a_single_number_or_character_is_checked() -> None:
    assert wire.number(-2, "h") == b"\xff\xfe"
    assert wire.char("ü") == b"\xfc"
    with pytest.raises(EncodeError, match="v: 70000 is not a whole number from -32768"):
        wire.number(70000, "h", "v")
    for letter in ("", "ab", "€"):
        with pytest.raises(EncodeError, match="is not one character of Latin-1"):
            wire.char(letter, "v")


def test_flags_that_are_not_declared_are_refused() -> None:
    source = Decoder(struct.pack(">I", 5))
    assert source.flags(Axes, source.number("I"), 3) == Axes.X | Axes.Z
    assert refusal(
        struct.pack(">I", 8), lambda source: source.flags(Axes, source.number("I"), 3, "axes")
    ) == (DecodeProblem.OUT_OF_RANGE, 0, "axes")


def read_map(source: Decoder) -> dict[str, int]:
    return source.mapping(source.string, lambda: source.number("b"), 6, 3, "ports")


def test_a_map_comes_back_in_order() -> None:
    data = b"\0\0\0\2" + wire.string("a") + b"\1" + wire.string("ä") + b"\2"
    assert read_map(Decoder(data)) == {"a": 1, "ä": 2}


@pytest.mark.parametrize("keys", ["ba", "aa"])
def test_the_keys_of_a_map_ascend_and_come_once(keys: str) -> None:
    data = b"\0\0\0\2" + b"".join(wire.string(key) + b"\1" for key in keys)
    assert refusal(data, read_map) == (DecodeProblem.UNSORTED_MAP, 11, "ports")


def test_a_map_has_no_more_than_its_bytes_or_its_bound() -> None:
    assert refusal(b"\0\0\0\2" + bytes(11), read_map)[0] is DecodeProblem.TRUNCATED
    assert refusal(b"\0\0\0\4" + bytes(99), read_map)[0] is DecodeProblem.OVER_BOUND


def test_an_appendable_value_stands_in_its_block() -> None:
    out: Parts = []
    wire.put_block(Byte(7), Byte, out, "Byte")
    assert b"".join(out) == b"\0\0\0\1\7"
    source = Decoder(b"\0\0\0\3\7\x08\x09")
    assert Byte.decode(source.block()) == Byte(7)
    source.expect_end()


def test_values_with_arrays_compare_by_content() -> None:
    one, two = np.array([1.0, 2.0]), np.array([1.0, 3.0])
    assert wire.same(one, one.copy())
    assert not wire.same(one, two)
    assert not wire.same(one, None)
    assert wire.same([one, {"k": two}], [one.copy(), {"k": two.copy()}])
    assert not wire.same([one], [one, two])
    assert not wire.same({"k": one}, {"j": one})
    assert wire.same(None, None) and wire.same(Byte(1), Byte(1)) and not wire.same(1, 2)


def test_a_new_array_is_zero() -> None:
    zeros = wire.zeros("h", 2, 3)
    assert zeros.shape == (2, 3) and zeros.dtype == np.int16 and not zeros.any()


@pytest.mark.parametrize(
    ("kind", "data", "path"),
    [
        (layout.secret("B"), 4711, "pin"),
        (layout.secret(layout.items("f")), [0.5, 4.711e47], "pin[1]"),
        (layout.secret(layout.mapping(layout.text(), "B")), [["a", 4711]], "pin[0]"),
    ],
)
def test_no_json_error_shows_a_secret(kind: Kind, data: Any, path: str) -> None:
    with pytest.raises(wire.JsonError, match=r"\*\*\* is not") as caught:
        kind.made(data, "pin")
    assert caught.value.path == path
    assert "4711" not in str(caught.value) and "4.711" not in str(caught.value)


def test_arguments_that_two_threads_use_first_are_read_whole() -> None:
    """The other thread comes while the first one prepares the members."""
    took: list[tuple[Any, ...]] = []
    comes = [True]

    class Interrupted(Arguments):
        __slots__ = ()

        def _each_group(self) -> Iterator[Any]:
            for group in super()._each_group():
                yield group
                if comes:
                    comes.clear()
                    took.append(self.decode(Decoder(encoded)))

    encoded = struct.pack(">d4sd", 0.5, b"\0\0\0\0", 1.5)
    arguments = Interrupted("go", ("x", "words", "y"), ["d", layout.items("B"), "d"], ())
    assert arguments.decode(Decoder(encoded)) == (0.5, [], 1.5)
    assert took == [(0.5, [], 1.5)]
    assert arguments.decode(Decoder(encoded)) == (0.5, [], 1.5)
