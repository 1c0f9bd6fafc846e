"""A range is checked wherever a number stands, on sending and on receipt."""

from __future__ import annotations

import re
import struct
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from gecos import wire
from gecos.errors import DeclaredError
from generating import generate

# Each value is 0 when it is made; 4.0 or 4 is outside.
IDL = """
module ranged {
  @unit("rad") @range(min=-3, max=3) typedef double Angle;
  typedef Angle Joints[2];
  typedef sequence<Joints> Path;
  @range(min=-3, max=3) typedef long Step;
  @max(3) typedef uint64 Count;
  @range(min=-0.5, max=0.7) typedef float Part;
  @max(3) typedef int8 Tick;

  @final struct Array { Angle x[2]; };
  @final struct Grid { Angle x[2][1]; };
  @final struct Items { sequence<Angle> x; };
  @final struct Nested { Path x; };
  @final struct Chain { @max(2.5) Angle x; };
  @final struct Own { @range(min=-3, max=3) double x[2]; };
  @final struct OwnItems { @range(min=-3, max=3) sequence<double> x; };
  @final struct Whole { @range(min=-3, max=3) sequence<long> x; };
  @final struct Steps { Step x[2]; };
  @final struct Counts { sequence<Count> x; };
  @final struct One { Count x; };
  @final struct Parts { Part x[2]; };
  @final struct Single { Part x; };
  @final struct Exact { @range(min=-2.3, max=-2.3) float x; };
  @final struct Exacts { @range(min=-2.3, max=-2.3) sequence<float> x; };
  @final struct Ticks { sequence<Tick> x; };
  @final struct Key { @max(3) octet x[2]; };
  @final struct Octets { @max(3) sequence<octet> x; };
  @final struct Optional { @optional Angle x; };
  @final struct OptionalItems { @optional sequence<Step> x; };
  @final struct Keys { map<Step, double> x; };
  @final struct Values { map<string, Angle> x; };
  @final struct MapItems { map<string, Joints> x; };
  @appendable struct Grows { double first; Joints x; };
  exception Failed { Joints x; };
  union Arm switch (boolean) { case TRUE: Joints x; };
  union Number switch (boolean) { case TRUE: Step x; };

  @version("1.0") interface Robot {
    Angle get();
    Joints both(out sequence<Step> steps, in map<string, Angle> names, @max(3) in double alone);
    @sensor @stream(rate="1Hz") readonly attribute Joints posture;
    attribute Part share;
  };
};
"""


@pytest.fixture(scope="module")
def types(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    out = tmp_path_factory.mktemp("ranged")
    (out / "ranged.gidl").write_text(IDL)
    generate(out, out / "ranged.gidl")
    sys.path.insert(0, str(out / "python"))
    yield import_module("ranged_types")
    sys.path.remove(str(out / "python"))


NAN = float("nan")
# Type, what is allowed, what is not.
CASES: list[tuple[str, Any, list[Any]]] = [
    ("Array", np.array([3.0, -3.0]), [np.array([0.0, 4.0]), np.array([NAN, 0.0]), [0.0, -4.0]]),
    ("Grid", np.zeros((2, 1)), [np.array([[0.0], [4.0]])]),
    ("Items", [3.0], [[4.0], np.array([0.0, NAN]), [0, 5]]),
    ("Nested", [[3.0, 0.0]], [[[0.0, 4.0]], [[0.0, 0.0], [NAN, 0.0]]]),
    ("Chain", 2.5, [2.75, NAN, -4.0]),
    ("Own", [3.0, -3.0], [[0.0, 4.0], [NAN, 0.0]]),
    ("OwnItems", [3.0, -3.0], [[0.0, 4.0], [NAN]]),
    ("Whole", [3, -3], [[0, 4], np.array([-4], "i4")]),
    ("Steps", [3, -3], [[0, 4]]),
    ("Counts", [3, 0], [[4], np.array([2**64 - 1], "u8")]),
    ("One", 3, [4, 2**64 - 1]),
    ("Parts", np.array([0.7, -0.5], "f4"), [np.array([0.71, 0.0], "f4"), [NAN, 0.0]]),
    ("Single", 0.7, [0.8, -0.6, NAN]),
    ("Exact", -2.3, [-2.2, -2.4, NAN]),
    ("Exacts", np.array([-2.3]), [[-2.2], np.array([-2.4], "f4"), [NAN]]),
    ("Ticks", [3, -128], [[4]]),
    ("Key", b"\3\0", [b"\0\4"]),
    ("Octets", b"\3\0", [b"\4", b"\0\xff"]),
    ("Optional", 3.0, [4.0, NAN]),
    ("OptionalItems", [3], [[4]]),
    ("Keys", {3: 9.0}, [{4: 0.0}]),
    ("Values", {"a": 3.0}, [{"a": 4.0}, {"a": NAN}]),
    ("MapItems", {"a": [3.0, 3.0]}, [{"a": [0.0, 4.0]}]),
    ("Grows", [3.0, 3.0], [[0.0, 4.0]]),
    ("Failed", [3.0, 3.0], [[0.0, 4.0]]),
]


def both(kind: Any, name: str) -> Iterator[Callable[..., Any]]:
    """`encode` or `decode`, and what a plan calls where it gives up."""
    yield getattr(kind, name)
    if hasattr(getattr(kind, name), "__wrapped__"):
        inner = getattr(kind, name).__wrapped__
        yield inner.__func__.__get__(kind) if name == "decode" else inner


@pytest.mark.parametrize(("name", "good", "bad"), CASES, ids=lambda x: x if type(x) is str else "")
def test_what_is_outside_is_not_sent(types: Any, name: str, good: Any, bad: list[Any]) -> None:
    kind = getattr(types, name)
    for encode in both(kind, "encode"):
        encode(kind(x=good), [])
        for value in bad:
            with pytest.raises(wire.EncodeError, match=rf"^{name}\.x(\[\d\])*: .* is outside \["):
                encode(kind(x=value), [])


@pytest.mark.parametrize(("name", "good", "bad"), CASES, ids=lambda x: x if type(x) is str else "")
def test_what_is_outside_is_not_received(types: Any, name: str, good: Any, bad: list[Any]) -> None:
    """The bytes of a good value, with each number in turn made one that is outside."""
    kind = getattr(types, name)
    refused = 0
    data = wire.to_bytes(kind(x=good))
    for decode in both(kind, "decode"):
        decode(wire.Decoder(data))
        for wrong in _with_a_number_outside(data):
            try:
                decode(wire.Decoder(wrong))
            except wire.DecodeError as error:
                refused += error.problem is wire.DecodeProblem.OUT_OF_RANGE
                if error.problem is wire.DecodeProblem.OUT_OF_RANGE:
                    assert error.field == f"{name}.x"
    assert refused > 0


def _with_a_number_outside(data: bytes) -> Iterator[bytes]:
    for code, number in (("d", 4.0), ("d", NAN), ("f", 4.0), ("i", 100), ("q", 100), ("b", 100)):
        raw = struct.pack(f">{code}", number)
        for at in range(len(data) - len(raw) + 1):
            yield data[:at] + raw + data[at + len(raw) :]


WITH_UNIT = (
    *("Array", "Grid", "Items", "Nested", "Chain", "Optional", "Values", "MapItems", "Grows"),
    "Failed",
)


@pytest.mark.parametrize(
    ("name", "good", "bad"), [c for c in CASES if c[0] in WITH_UNIT], ids=lambda x: str(x)[:8]
)
def test_the_unit_of_a_typedef_is_named_everywhere(
    types: Any, name: str, good: Any, bad: list[Any]
) -> None:
    kind = getattr(types, name)
    for value in bad:
        with pytest.raises(wire.EncodeError, match=r" is outside \[.*\] rad"):
            kind(x=value).encode([])
    for wrong in _with_a_number_outside(wire.to_bytes(kind(x=good))):
        try:
            kind.decode(wire.Decoder(wrong))
        except wire.DecodeError as error:
            if error.problem is wire.DecodeProblem.OUT_OF_RANGE:
                assert re.search(r"byte \d+: .* is outside \[.*\] rad", str(error))


def test_arms_are_checked(types: Any) -> None:
    with pytest.raises(
        wire.EncodeError, match=r"Arm\.x\[1\]: 4\.0 is outside \[-3.0, 3.0\] rad; is"
    ):
        wire.to_bytes(types.Arm.make_x(np.array([0.0, 4.0])))
    for made in (types.Arm.make_x(np.array([0.0, 4.0])), types.Number.make_x(4)):
        with pytest.raises(wire.EncodeError, match="is outside"):
            wire.to_bytes(made)
    raw = bytearray(wire.to_bytes(types.Number.make_x(3)))
    raw[-1] = 4
    with pytest.raises(wire.DecodeError, match=r"x' at byte \d+: 4 is outside \["):
        wire.from_bytes(types.Number, raw)


def test_parameters_results_and_samples_are_checked(types: Any) -> None:
    module = import_module("ranged")
    handlers = {h.method: h for h in module.RobotServant._gecos_handlers.values()}
    with pytest.raises(wire.EncodeError, match=r"get: 4\.0 is outside"):
        handlers["get"].result(4.0)
    with pytest.raises(wire.EncodeError, match=r"steps\[0\]: 4 is outside"):
        handlers["both"].result(types.Robot_both_result(np.zeros(2), np.array([4], "i4")))
    with pytest.raises(wire.EncodeError, match=r"posture\[1\]: 4\.0 is outside"):
        handlers["posture"].result(np.array([0.0, 4.0]))
    with pytest.raises(wire.EncodeError, match=r"share: 4\.0 is outside"):
        handlers["share"].result(4.0)
    sent: wire.Parts = []
    proxy = object.__new__(module.Robot)
    object.__setattr__(proxy, "_gecos_call", lambda method, parts: sent.extend(parts))
    with pytest.raises(wire.EncodeError, match=r"both\.names: 4\.0 is outside"):
        proxy.both({"a": 4.0}, 1.0)
    proxy.both({"a": 3.0}, 3.0)
    data = b"".join(sent)
    handlers["both"].arguments(wire.Decoder(data))
    for at in (-8, -16):
        wrong = data[:at] + struct.pack(">d", 4.0) + data[len(data) + at + 8 :]
        with pytest.raises(wire.DecodeError, match=r"4\.0 is outside \["):
            handlers["both"].arguments(wire.Decoder(wrong))
    with pytest.raises(wire.DecodeError, match=r"nan is outside \["):
        module._ROBOT_POSTURE.result(wire.Decoder(struct.pack(">dd", 0.0, NAN)))


def test_exceptions_are_checked(types: Any) -> None:
    assert issubclass(types.Failed, DeclaredError)
    with pytest.raises(wire.EncodeError, match=r"Failed\.x\[0\]: 4\.0 is outside"):
        types.Failed(np.array([4.0, 0.0])).encode([])


def test_a_float_at_its_bound_is_sent_and_received(types: Any) -> None:
    """0.7 is no number of single precision: what is sent is compared before it is rounded, what is
    received with the rounded bound."""
    assert wire.from_bytes(types.Single, wire.to_bytes(types.Single(0.7))).x == np.float32(0.7)
    for exact in (-2.3, float(np.float32(-2.3))):
        for encode in both(types.Exact, "encode"):
            encode(types.Exact(exact), [])
        sent = wire.to_bytes(types.Exact(exact))
        assert wire.from_bytes(types.Exact, sent).x == np.float32(-2.3)
        for code in ("f4", "f8"):
            wire.to_bytes(types.Exacts(np.array([exact], code)))
    parts = types.Parts(np.array([0.7, -0.5]))
    assert list(wire.from_bytes(types.Parts, wire.to_bytes(parts)).x) == [np.float32(0.7), -0.5]
