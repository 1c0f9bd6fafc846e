"""Codecs in one go beside those in Python: the same bytes, values and errors, whatever they get."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compare_verdicts import hostile
from gecos import wire
from gecos.wire import plans
from gidl.model import Model
from robcl.geometry_types import Vector
from robcl.manipulator_types import PathType, Trajectory
from type_values import TREE, Case, cases, python_struct, python_type

ODD = (
    None, True, False, 0, 1, -1, 255, 2**31, 2**53 + 1, -(2**63), 2**64, 0.5, -0.0, 1e300,
    float("nan"), float("inf"), np.float64(0.5), np.float32(0.5), np.int64(1), np.True_,
    PathType.JOINT, "", "a", "ä" * 40, "\0", "\ud800", b"", b"ab", bytearray(b"ab"), [], [0.5],
    [1], [None], (0.5, 0.5), [0.5] * 3, ["a"], np.zeros(3), np.zeros(4), np.zeros((3, 2)),
    np.zeros(6)[::2], np.zeros(3, ">f8"), np.zeros(3, "f4"), np.zeros(3, "i4"), np.ones(3, "?"),
    np.full(3, 1e9), Trajectory(), Vector(), object,
)  # fmt: skip


def compiled_cases(model: Model) -> list[Case]:
    """The cases of types that have a plan."""
    return [c for c in cases() if hasattr(python_type(model, c.type).encode, "__wrapped__")]


def seen(value: Any) -> Any:
    """All that can be seen of a value, types included."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes(), value.flags.writeable
    if is_dataclass(value):
        return type(value), [seen(getattr(value, member.name)) for member in fields(value)]
    return type(value), [seen(each) for each in value] if type(value) is list else repr(value)


def said(act: Callable[[], Any]) -> tuple[type, Any]:
    """What comes of it: what it gives, or which error it raises with which text."""
    try:
        return object, act()
    except Exception as error:
        return type(error), str(error).split(" object at ")[0]


def encoded(encode: Callable[[Any, wire.Parts], None], value: Any) -> tuple[type, Any]:
    out: wire.Parts = []
    kind, what = said(lambda: encode(value, out))
    return kind, what if kind is not object else b"".join(out)


def decoded(decode: Callable[[wire.Decoder], Any], data: bytes) -> tuple[type, Any, int]:
    source = wire.Decoder(b"???" + data)
    source.offset = 3
    kind, what = said(lambda: seen(decode(source)))
    return kind, what, source.offset if kind is object else 0


def test_the_extension_is_there_and_most_types_have_plans(model: Model, everything: Path) -> None:
    assert plans.COMPILED
    assert len({case.type for case in compiled_cases(model)}) >= 20


def test_the_usual_case_never_comes_to_python(model: Model, everything: Path) -> None:
    called: list[str] = []

    def watch(frame: Any, event: str, argument: object) -> None:
        if event == "call" and frame.f_code.co_name in ("encode", "decode"):
            called.append(f"{frame.f_code.co_filename}: {frame.f_code.co_qualname}")

    for case in compiled_cases(model):
        kind = python_type(model, case.type)
        value = python_struct(model, case.type, case.value)
        read = wire.from_bytes(kind, case.bytes)
        sys.setprofile(watch)
        try:
            written = wire.to_bytes(read)
            again = wire.from_bytes(kind, case.bytes)
        finally:
            sys.setprofile(None)
        assert (written, again) == (case.bytes, value), case.id
    assert called == []


def test_unusual_values_are_written_or_refused_as_by_python(model: Model, everything: Path) -> None:
    written = 0
    for case in compiled_cases(model):
        kind = python_type(model, case.type)
        for member in fields(kind):
            for odd in ODD:
                value = deepcopy(wire.from_bytes(kind, case.bytes))
                setattr(value, member.name, odd)
                ours = encoded(kind.encode, value)
                assert ours == encoded(kind.encode.__wrapped__, value), (case.id, member.name, odd)
                written += ours[0] is object
    assert written > 500


def test_bytes_are_read_or_refused_as_by_python(model: Model, everything: Path) -> None:
    known, read = {case.type for case in compiled_cases(model)}, 0
    for name, data in hostile(random.Random(20261121), 6000):
        if name in known:
            kind = python_type(model, name)
            ours = decoded(kind.decode, data)
            assert ours == decoded(kind.decode.__wrapped__, data), (name, data.hex())
            read += ours[0] is object
    assert read > 300


def _framed() -> Iterator[tuple[str, Callable[[Any], Any]]]:
    yield "put", lambda value: encoded(lambda v, out: wire.put(v, type(v), out, "here"), value)
    yield (
        "put_block",
        lambda value: encoded(lambda v, out: wire.put_block(v, type(v), out, "here"), value),
    )
    yield "to_message", wire.to_message
    yield "to_bytes", wire.to_bytes


@pytest.mark.parametrize("name, frame", [*_framed()], ids=lambda x: x if isinstance(x, str) else "")
def test_each_way_to_write_gives_what_python_gives(
    name: str, frame: Callable[[Any], Any], model: Model, everything: Path, monkeypatch: Any
) -> None:
    values = [wire.from_bytes(python_type(model, c.type), c.bytes) for c in compiled_cases(model)]
    ours = [frame(value) for value in values]
    monkeypatch.setattr(wire, name, getattr(wire, name).__wrapped__)
    assert ours == [frame(value) for value in values]


@pytest.mark.parametrize("kind", [bytes, bytearray, memoryview])
def test_messages_are_read_from_any_bytes(
    kind: type[bytes], model: Model, everything: Path
) -> None:
    for case in compiled_cases(model):
        mine = python_type(model, case.type)
        value = wire.from_bytes(mine, kind(case.bytes))
        message = wire.to_message(value)
        assert seen(wire.from_message(mine, kind(message))) == seen(value)
        for wrong in (b"", message[:7], bytes(8) + message[8:], message + b"\0"):
            python = said(lambda m=wrong, k=mine: seen(wire.from_message.__wrapped__(k, m)))
            assert said(lambda m=wrong, k=mine: seen(wire.from_message(k, m))) == python


def test_nothing_is_kept_of_what_was_written_and_read(model: Model, everything: Path) -> None:
    known = [(python_type(model, case.type), case.bytes) for case in compiled_cases(model)]
    shared: list[object] = [None, True, False, PathType.JOINT, b"", *(kind for kind, _ in known)]

    def references() -> list[int]:
        return [sys.getrefcount(each) for each in shared]

    before = references()
    for _ in range(200):
        for kind, data in known:
            wire.from_message(kind, wire.to_message(wire.from_bytes(kind, data)))
            said(lambda kind=kind, data=data: wire.from_bytes(kind, data + b"\0"))
    grown = [now - then for now, then in zip(references(), before, strict=True)]
    assert max(grown) < 100, grown


def test_a_decoder_ends_where_it_was_told_to() -> None:
    source = wire.Decoder(wire.to_bytes(Vector(1.0, 2.0, 3.0)))
    source.end = 20
    with pytest.raises(wire.DecodeError, match=r"field 'Vector\.z' at byte 16: the bytes end"):
        Vector.decode(source)


def test_an_array_of_a_new_value_is_its_own(everything: Path) -> None:
    kind = import_module("robcl.six_axis_types").Joints
    raw = bytearray(wire.to_bytes(kind()))
    value = wire.from_bytes(kind, raw)
    raw[:] = b"\xff" * len(raw)
    assert seen(value) == seen(kind())


def test_without_the_extension_all_is_python() -> None:
    program = """
import sys
sys.modules["gecos.wire._plans"] = None
from gecos import wire
from gecos.wire import plans
from robcl.manipulator_types import Trajectory
value = Trajectory(0.5, tool_speed=0.25)
assert not plans.COMPILED and not hasattr(Trajectory.encode, "__wrapped__")
assert wire.from_message(Trajectory, wire.to_message(value)) == value
print(wire.to_message(value).hex())
"""
    path = f"{TREE / 'runtime/python'}:{TREE / 'generated/python'}"
    printed = subprocess.run(
        [sys.executable, "-c", program], env={"PYTHONPATH": path}, check=True,
        capture_output=True, text=True,
    ).stdout  # fmt: skip
    assert printed.strip() == wire.to_message(Trajectory(0.5, tool_speed=0.25)).hex()


@pytest.mark.parametrize(
    ("steps", "why"),
    [
        (["d", "d", "x"], "'x' is not the type code of a number"),
        ([("struct", object), "d", "d"], "has no plan"),
        ([("rubbish",), "d", "d"], "a plan has no kind of step that is called rubbish"),
        ([("items", "d", 0, None, 3), "d", "d"], "each item of a plan must take at least one byte"),
    ],
)
def test_a_plan_that_is_none_is_refused(steps: list[Any], why: str) -> None:
    members = list(zip("xyz", steps, strict=True))
    with pytest.raises((TypeError, ValueError), match=why):
        plans._plans.struct(Vector, 0, members, [], False, Vector.encode, Vector.decode)
    assert wire.to_bytes(Vector(1.0, 2.0, 3.0)) == np.array([1, 2, 3], ">f8").tobytes()
