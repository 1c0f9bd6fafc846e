"""Bytes where numbers of eight bits are declared, and characters of all of Latin-1."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from gecos import wire
from gecos.wire.json import dumps, loads
from generating import generate

IDL = """
module small {
  typedef sequence<uint8, 4> Few;
  @final struct Bytes { sequence<uint8> s; uint8 a[3]; small::Few few;
    octet raw[2]; sequence<octet> raws; };
  @final struct Limited { @max(9) sequence<uint8> s; sequence<int8> signed_ones; };
  const char LAST = '\\xff';
  const char NUL = '\\0';
  @final struct Letters { char one; sequence<char> more; char two[2];
    @default('\\xff') char last; };
  union Letter switch (char) { case '\\xff': long last; case '\\0': string nul; case 'a': char a; };
  @version("1.0") interface Camera {
    sequence<uint8> take(in sequence<uint8> picture, in char letter);
    @sensor @stream(rate="1Hz") readonly attribute sequence<uint8> latest;
  };
};
"""


@pytest.fixture(scope="module")
def types(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    out = tmp_path_factory.mktemp("small")
    (out / "small.gidl").write_text(IDL)
    generate(out, out / "small.gidl")
    sys.path.insert(0, str(out / "python"))
    yield import_module("small_types")
    sys.path.remove(str(out / "python"))


@pytest.mark.parametrize("kind", [bytes, bytearray, memoryview, np.frombuffer], ids=str)
def test_bytes_are_sent_where_numbers_of_eight_bits_are_declared(types: Any, kind: Any) -> None:
    def of(raw: bytes) -> Any:
        return np.frombuffer(raw, "u1") if kind is np.frombuffer else kind(raw)

    value = types.Bytes(of(b"\x00\xff"), of(b"abc"), of(b"1234"), b"xy", b"z")
    read = wire.from_bytes(types.Bytes, wire.to_bytes(value))
    assert (read.s.tobytes(), read.a.tobytes(), read.few.tobytes()) == (
        b"\x00\xff",
        b"abc",
        b"1234",
    )
    assert (read.raw, read.raws) == (b"xy", b"z")
    assert read == value
    assert loads(types.Bytes, dumps(value)) == value


def test_bytes_are_checked_like_arrays(types: Any) -> None:
    for value, words in (
        (
            types.Bytes(a=b"ab"),
            r"Bytes\.a: the array has shape \(2,\); give an array of the declared shape \(3,\)",
        ),
        (types.Bytes(few=b"12345"), r"Bytes\.few: 5 elements, at most 4"),
        (types.Limited(b"\x09\x0a"), r"Limited\.s\[1\]: 10 is outside \[-inf, 9\]"),
        (types.Limited(signed_ones=b"ab"), r"Limited\.signed_ones: the array has"),
        (types.Bytes(raws=3), r"Bytes\.raws: 3 is not bytes"),
        (types.Bytes(raws=np.zeros(2)), r"Bytes\.raws: .* is not bytes"),
        (types.Letters(one=65), r"Letters\.one: 65 is not one character of Latin-1"),
        (types.Letters(more=[b"a"]), r"Letters\.more: b'a' is not one character of Latin-1"),
        (types.Letters(more=5), r"Letters\.more: 5 is not a list or an array"),
        (types.Bytes(raw=[1, 256]), r"Bytes\.raw: .* is not bytes"),
    ):
        with pytest.raises(wire.EncodeError, match=words):
            wire.to_bytes(value)


def test_calls_take_and_give_bytes(types: Any) -> None:
    module = import_module("small")
    handlers = {h.method: h for h in module.CameraServant._gecos_handlers.values()}
    sent: wire.Parts = []
    proxy = object.__new__(module.Camera)
    object.__setattr__(proxy, "_gecos_call", lambda method, parts: sent.extend(parts))
    proxy.take(b"ab", "\xff")
    picture, letter = handlers["take"].arguments(wire.Decoder(b"".join(sent)))
    assert (picture.tobytes(), letter) == (b"ab", "\xff")
    source = wire.Decoder(b"".join(handlers["take"].result(b"cd")))
    assert module._CAMERA_TAKE.result(source).tobytes() == b"cd"
    hints = module.Camera.take.__annotations__
    assert hints["picture"] == "_npt.NDArray[_np.uint8] | bytes"
    assert hints["return"] == "_Command[_npt.NDArray[_np.uint8]]"


def test_all_of_latin_1_is_sent_and_received(types: Any) -> None:
    assert (types.LAST, types.NUL, types.Letters().last) == ("\xff", "\0", "\xff")
    for number in range(256):
        value = types.Letters(chr(number), [chr(number)] * 2, [chr(number), "\0"])
        assert wire.to_bytes(value)[0] == number
        assert wire.from_bytes(types.Letters, wire.to_bytes(value)) == value
        assert loads(types.Letters, dumps(value)) == value


def test_characters_select_arms(types: Any) -> None:
    for value in (
        types.Letter.make_last(5), types.Letter.make_nul("x"), types.Letter.make_a("\xff"),
        types.Letter("b"),
    ):  # fmt: skip
        assert wire.from_bytes(types.Letter, wire.to_bytes(value)) == value
        assert loads(types.Letter, dumps(value)) == value
    assert types.Letter.make_last(5).tag == "\xff"
    assert wire.to_bytes(types.Letter.make_last(5))[:4] == b"\0\0\0\xff"
