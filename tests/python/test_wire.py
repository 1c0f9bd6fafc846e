"""The Python codec by itself: what it writes, what it refuses to write, and its interfaces."""

from __future__ import annotations

import math
import pickle
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Self

import numpy as np
import pytest
from gecos import wire
from gecos.wire import DecodeError, DecodeProblem, Decoder, EncodeError, Fields, Parts
from gecos.wire.plans import from_start
from hypothesis import given
from hypothesis import strategies as st
from robcl.geometry_types import Vector
from robcl.manipulator_types import Trajectory
from robcl.six_axis_types import Joints


class Mode(IntEnum):
    IDLE = 0
    BUSY = 1


@dataclass(slots=True)
class Reading:
    """What generated code looks like, in small."""

    metres: float
    valid: bool
    label: str

    def encode(self, out: Parts) -> None:
        out.append(_READING.pack(self.metres, self.valid))
        out.append(wire.string(self.label, 8, "label"))

    @classmethod
    def decode(cls, source: Decoder) -> Self:
        metres, valid = _READING.unpack(source)
        return cls(metres, valid, source.string(8, "label"))

    @staticmethod
    def fingerprint() -> int:
        return 0xFEDC_BA98_7654_3210


_READING = Fields("d?", ("metres", "valid"))


def refusal(data: bytes | memoryview, read: object) -> DecodeError:
    with pytest.raises(DecodeError) as caught:
        read(Decoder(data))  # type: ignore[operator]
    return caught.value


def test_a_value_is_its_fields_in_order() -> None:
    value = Reading(0.5, True, "left")
    data = wire.to_bytes(value)
    assert data == struct.pack(">d?i", 0.5, True, 5) + b"left\0"
    assert wire.from_bytes(Reading, data) == value
    assert wire.from_bytes(Reading, memoryview(bytearray(data))) == value


def test_a_message_has_its_fingerprint_in_front() -> None:
    value = Reading(1.0, False, "")
    message = wire.to_message(value)
    assert message[:8].hex() == "fedcba9876543210"
    assert wire.from_message(Reading, message) == value


def test_a_message_of_another_type_is_refused() -> None:
    message = bytes(8) + wire.to_bytes(Reading(1.0, False, ""))
    with pytest.raises(DecodeError, match="a message of another type") as caught:
        wire.from_message(Reading, message)
    assert (caught.value.problem, caught.value.offset) == (DecodeProblem.WRONG_FINGERPRINT, 0)


def test_bytes_left_over_are_refused() -> None:
    data = wire.to_bytes(Reading(1.0, False, ""))
    with pytest.raises(DecodeError) as caught:
        wire.from_bytes(Reading, data + b"\0")
    assert (caught.value.problem, caught.value.offset) == (
        DecodeProblem.TRAILING_BYTES,
        len(data),
    )


@pytest.mark.parametrize("size", range(14))
def test_every_cut_is_refused(size: int) -> None:
    data = wire.to_bytes(Reading(1.0, True, ""))
    assert len(data) == 14
    with pytest.raises(DecodeError) as caught:
        wire.from_bytes(Reading, data[:size])
    assert caught.value.problem is DecodeProblem.TRUNCATED
    assert caught.value.field == ("metres" if size < 8 else "valid" if size < 9 else "label")


def test_an_error_names_field_byte_and_reason() -> None:
    error = refusal(struct.pack(">dB", 1.0, 2), _READING.unpack)
    assert str(error) == "field 'valid' at byte 8: a boolean must be 0 or 1"
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.problem, again.offset) == (str(error), error.problem, 8)


def test_an_invalid_boolean_is_reported_before_the_end_that_comes_after_it() -> None:
    run = Fields("?d", ("valid", "metres"))
    error = refusal(b"\7\0", run.unpack)
    assert (error.problem, error.offset, error.field) == (
        DecodeProblem.INVALID_BOOLEAN,
        0,
        "valid",
    )


def test_booleans_are_written_as_0_and_1_and_read_as_bool() -> None:
    run = Fields("??", ("a", "b"))
    assert run.pack(False, True) == b"\0\1"
    assert run.unpack(Decoder(b"\0\1")) == (False, True)
    assert all(type(value) is bool for value in run.unpack(Decoder(b"\0\1")))


@pytest.mark.parametrize(
    ("code", "value", "meaning"),
    [
        ("b", 128, "128 is not a whole number from -128 to 127"),
        ("B", -1, "-1 is not a whole number from 0 to 255"),
        ("i", 1.5, "1.5 is not a whole number"),
        ("I", 2**32, "4294967296 is not a whole number from 0 to 4294967295"),
        ("Q", -1, "-1 is not a whole number"),
        ("f", 1e300, "1e\\+300 is not a number that fits in single precision"),
        ("d", "1", "'1' is not a number"),
        ("d", None, "None is not a number"),
    ],
)
def test_a_number_that_does_not_fit_is_named(code: str, value: object, meaning: str) -> None:
    with pytest.raises(EncodeError, match=f"second: {meaning}"):
        Fields("d" + code, ("first", "second")).pack(0.0, value)


def test_packing_too_few_values_is_a_programming_error() -> None:
    with pytest.raises(TypeError, match="2 values expected, 1 given"):
        _READING.pack(1.0)


def test_strings_that_cannot_be_sent_are_refused() -> None:
    with pytest.raises(EncodeError, match="name: 5 bytes of text, at most 4"):
        wire.string("Gerä", 4, "name")
    with pytest.raises(EncodeError, match="name: None is not a string"):
        wire.string(None, field="name")  # type: ignore[arg-type]
    with pytest.raises(EncodeError, match="contains NUL"):
        wire.string("a\0b", field="name")
    with pytest.raises(EncodeError, match="cannot be encoded as UTF-8: surrogates not allowed"):
        wire.string("\ud800", field="name")


def test_a_count_above_its_bound_is_refused() -> None:
    assert wire.count(3, 3) == b"\0\0\0\3"
    with pytest.raises(EncodeError, match="joints: 4 elements, at most 3 are allowed"):
        wire.count(4, 3, "joints")


@pytest.mark.parametrize(
    ("values", "code", "expected"),
    [
        ([1.0, -2.0], "d", struct.pack(">2d", 1.0, -2.0)),
        ([1, 2], "d", struct.pack(">2d", 1.0, 2.0)),
        (np.array([1, 2], np.int64), "h", struct.pack(">2h", 1, 2)),
        (np.array([255], np.int32), "B", b"\xff"),
        (np.array([0.1]), "f", struct.pack(">f", 0.1)),
        (np.arange(6.0).reshape(2, 3).T, "d", struct.pack(">6d", 0, 3, 1, 4, 2, 5)),
        (np.arange(8.0)[::2], "d", struct.pack(">4d", 0, 2, 4, 6)),
        (np.array([1.0], ">f8"), "d", struct.pack(">d", 1.0)),
        ([True, False], "?", b"\1\0"),
        ([], "h", b""),
    ],
)
def test_arrays_are_written_big_endian(values: object, code: str, expected: bytes) -> None:
    assert b"".join([wire.array(values, code)]) == expected  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("values", "code", "why"),
    [
        ([1.5], "i", "an array of float64, but each element must be a whole number"),
        ([40_000], "h", "40000 is not a whole number from -32768 to 32767"),
        ([-1], "Q", "-1 is not a whole number from 0"),
        (["a"], "d", "an array of <U1, but each element must be a number"),
        ([2], "?", "an array of int64, but each element must be a boolean"),
    ],
)
def test_arrays_are_never_changed_silently(values: object, code: str, why: str) -> None:
    with pytest.raises(EncodeError, match=f"v: {why}"):
        wire.array(values, code, "v")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("values", "element", "number"),
    [
        (np.array([1.0, np.finfo(np.float64).max]), "v[1]", "1.7976931348623157e+308"),
        ([1e39], "v[0]", "1e+39"),
        (np.array([[1.0, 2.0], [-1e39, 1e300]]), "v[1][0]", "-1e+39"),
        (np.array([1e39], ">f8"), "v[0]", "1e+39"),
    ],
)
def test_an_array_never_makes_a_finite_number_infinite(
    values: object, element: str, number: str
) -> None:
    with pytest.raises(EncodeError) as refused:
        wire.array(values, "f", "v")  # type: ignore[arg-type]
    why = f"{number} is not a number that fits in single precision"
    assert str(refused.value) == f"{element}: {why}"


@pytest.mark.filterwarnings("error")
def test_what_is_already_infinite_or_no_number_is_sent_in_single_precision_too() -> None:
    largest = float(np.finfo(np.float32).max)
    values = [math.inf, -math.inf, math.nan, largest, -largest, 1e-300]
    sent = b"".join([wire.array(np.array(values), "f")])
    assert sent[:8] + sent[12:] == struct.pack(">5f", *values[:2], *values[3:])
    assert math.isnan(struct.unpack(">f", sent[8:12])[0])


def test_a_decoded_array_is_ones_own_in_native_order() -> None:
    data = bytearray(struct.pack(">3h", 1, -2, 3))
    numbers = Decoder(data).array("h", 3)
    data[:] = bytes(6)
    assert numbers.tolist() == [1, -2, 3]
    assert numbers.dtype == np.int16 and numbers.dtype.isnative and numbers.flags.writeable


def test_an_array_of_booleans_says_which_one_is_wrong() -> None:
    assert Decoder(b"\0\1").array("?", 2).tolist() == [False, True]
    error = refusal(b"\0\1\3\2", lambda source: source.array("?", 4, "switches"))
    assert (error.problem, error.offset) == (DecodeProblem.INVALID_BOOLEAN, 2)


def test_a_huge_count_costs_no_memory() -> None:
    import tracemalloc

    data = struct.pack(">i", 2**31 - 1) + bytes(100)
    tracemalloc.start()
    for read in (
        lambda source: source.count(1),
        lambda source: source.string(),
        lambda source: source.array("d", 2**40),
        lambda source: source.octets(2**40),
        lambda source: source.block(),
    ):
        assert refusal(data, read).problem is DecodeProblem.TRUNCATED
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 64 * 1024


def test_blocks_nest_and_hide_what_is_newer() -> None:
    inner = wire.block([b"\1", b"\2\3"])
    data = wire.block([inner, b"\4"]) + b"\5"
    source = Decoder(data)
    outer = source.block()
    assert outer.block().octets(1) == b"\1"
    assert outer.octets(1) == b"\4"
    assert source.octets(1) == b"\5"
    source.expect_end()


def test_enumerators_fall_back_only_where_the_enum_has_a_default() -> None:
    source = Decoder(struct.pack(">ii", 1, 9))
    assert source.enumerator(Mode, source.number("i")) is Mode.BUSY
    unknown = source.number("i")
    assert source.enumerator(Mode, unknown, Mode.IDLE) is Mode.IDLE
    with pytest.raises(DecodeError) as caught:
        source.enumerator(Mode, unknown, field="mode")
    assert (caught.value.problem, caught.value.offset, caught.value.field) == (
        DecodeProblem.UNKNOWN_ENUMERATOR,
        4,
        "mode",
    )


def test_depth_is_given_back() -> None:
    source = Decoder(b"")
    for _ in range(3):
        for _ in range(wire.MAX_DEPTH):
            source.enter()
        assert refusal_of_enter(source).problem is DecodeProblem.TOO_DEEP
        for _ in range(wire.MAX_DEPTH):
            source.leave()


def refusal_of_enter(source: Decoder) -> DecodeError:
    with pytest.raises(DecodeError) as caught:
        source.enter("deep")
    return caught.value


@given(st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"])))
def test_every_text_comes_back(words: str) -> None:
    source = Decoder(wire.string(words))
    assert source.string() == words
    source.expect_end()


@given(st.lists(st.floats(width=64)))
def test_every_array_comes_back_bit_by_bit(values: list[float]) -> None:
    data = wire.count(len(values)) + b"".join([wire.array(values, "d")])
    source = Decoder(data)
    back = source.array("d", source.count(8))
    assert back.tobytes() == np.array(values, dtype=np.float64).tobytes()


@given(st.binary(max_size=64))
def test_any_bytes_are_decoded_or_refused(data: bytes) -> None:
    try:
        value = wire.from_bytes(Reading, data)
    except DecodeError as error:
        assert 0 <= error.offset <= len(data)
    else:
        if not math.isnan(value.metres):
            assert wire.to_bytes(value) == data


def test_numpy_is_not_imported_before_the_first_array() -> None:
    program = (
        "import sys; from gecos import wire; wire.Decoder(wire.string('a')).string();"
        "assert 'numpy' not in sys.modules; wire.array([1.0], 'd'); assert 'numpy' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, env={"PYTHONPATH": _path()})


def _path() -> str:
    from os import pathsep

    return pathsep.join(sys.path)


def read_by(read: Callable[[bytes], Any], data: bytes) -> str:
    try:
        return repr(read(data))
    except wire.DecodeError as error:
        return f"{error.problem} at {error.offset} of {error.field}"


@pytest.mark.parametrize(
    "value",
    [Reading(1.5, True, "laser"), Vector(1.5, -2.0, 3.25), Trajectory(), Joints(np.arange(6.0))],
    ids=lambda value: type(value).__name__,
)
def test_the_bytes_of_a_reply_are_read_as_by_a_decoder(value: Any) -> None:
    decode = type(value).decode
    from_bytes = from_start(decode)
    whole = wire.to_bytes(value)
    for data in (
        *(whole[:size] for size in range(len(whole))),
        whole,
        whole + b"more",
        b"\xff" * 99,
    ):
        assert read_by(from_bytes, data) == read_by(lambda each: decode(Decoder(each)), data)
