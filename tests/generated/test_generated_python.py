"""Generated Python on the shared vectors, and what it refuses."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gecos import wire
from gecos.errors import CommandFailed
from gecos.wire.unions import NOT_OF_TAG
from gidl.model import Model, Struct
from type_values import Case, cases, python_struct, python_type

CASES = cases()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_value_becomes_the_bytes_of_the_vector(
    case: Case, model: Model, everything: Path
) -> None:
    assert wire.to_bytes(python_struct(model, case.type, case.value)) == case.bytes


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_bytes_become_an_equal_value(case: Case, model: Model, everything: Path) -> None:
    kind = python_type(model, case.type)
    value = wire.from_bytes(kind, case.bytes)
    wanted = python_struct(model, case.type, case.value)
    if isinstance(value, CommandFailed):  # exceptions are equal only to themselves
        assert str(value) == str(wanted)
    else:
        assert value == wanted
    assert wire.to_bytes(value) == case.bytes


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_bytes_cut_anywhere_are_refused(case: Case, model: Model, everything: Path) -> None:
    kind = python_type(model, case.type)
    declaration = model.find(case.type)
    grows = getattr(declaration, "extensibility", None)
    for size in range(len(case.bytes)):
        if grows is not None and grows.value == "appendable":
            continue  # a shorter one may be an older writer's; C++ agrees, see the verdicts
        with pytest.raises(wire.DecodeError):
            wire.from_bytes(kind, case.bytes[:size])


def test_every_type_has_a_vector(model: Model) -> None:
    covered = {case.type for case in CASES}
    structs = {d.name for d in model.declarations() if isinstance(d, Struct)}
    assert structs - covered == set()


@pytest.fixture
def types(everything: Path) -> Any:
    return import_module("everything_types")


def _refusals() -> Iterator[tuple[str, dict[str, Any], str]]:
    yield (
        "Limits",
        {"few": 1, "both": 1.5},
        "Limits.both: 1.5 is outside [-1.0, 1.0]; give at most 1.0",
    )
    yield (
        "Limits",
        {"few": 1, "both": float("nan")},
        "Limits.both: nan is outside [-1.0, 1.0]; give a number",
    )
    yield (
        "Limits",
        {"few": 1, "lower": -0.5},
        "Limits.lower: -0.5 is outside [0.0, inf]; give at least 0.0",
    )
    yield (
        "Limits",
        {"few": 1, "upper": 11},
        "Limits.upper: 11 is outside [-inf, 10]; give at most 10",
    )
    yield (
        "Limits",
        {"few": 1, "share": 101},
        "Limits.share: 101 is outside [0, 100]; give at most 100",
    )
    yield "Limits", {"few": 0}, "Limits.few: 0 is outside [1, 3]; give at least 1"
    yield (
        "Limits",
        {"few": "1"},
        "Limits.few: '1' is not a whole number from 0 to 65535; write the number without quotes "
        "and unit",
    )
    yield "Numbers", {"u8": 256}, "Numbers.u8: 256 is not a whole number from 0 to 255"
    yield "Numbers", {"letter": "ab"}, "Numbers.letter: 'ab' is not one character of Latin-1"
    yield "Numbers", {"twice": None}, "Numbers.twice: None is not a number; give a number"
    yield (
        "Sequences",
        {"few": np.zeros(4, "f4")},
        "Sequences.few: 4 elements, at most 3 are allowed",
    )
    yield (
        "Sequences",
        {"words": ["abcde"]},
        "Sequences.words: 5 bytes of text, at most 4 are allowed",
    )
    yield (
        "Sequences",
        {"percents": np.array([1, 101])},
        "Sequences.percents[1]: 101 is outside [0, 100]; give at most 100",
    )
    yield "Sequences", {"short_text": "a\0"}, "Sequences.short_text: 'a\\x00' contains NUL"
    yield (
        "Sequences",
        {"reals": np.zeros((2, 2))},
        ("Sequences.reals: the array has 2 dimensions, but a sequence has one"),
    )
    yield (
        "Arrays",
        {"grid": np.zeros((3, 2), "i4")},
        ("Arrays.grid: the array has shape (3, 2); give an array of the declared shape (2, 3)"),
    )
    yield "Arrays", {"names": ["a"]}, "Arrays.names: 1 elements, but 2 are declared"
    yield "Arrays", {"block": b"\0"}, "Arrays.block: 1 bytes, but 3 are declared"
    yield "Optionals", {"part": 2.0}, "Optionals.part: 2.0 is outside [0.0, 1.0]; give at most 1.0"
    yield "Shape", {"value": None}, f"Shape: {NOT_OF_TAG}"


@pytest.mark.parametrize(("kind", "members", "words"), list(_refusals()), ids=lambda x: str(x)[:40])
def test_what_must_not_be_sent_is_refused_by_its_name(
    types: Any, kind: str, members: dict[str, Any], words: str
) -> None:
    value = getattr(types, kind)(**members)
    with pytest.raises(wire.EncodeError) as caught:
        wire.to_bytes(value)
    assert str(caught.value) == words


def test_a_number_out_of_range_is_refused_where_it_lies(types: Any) -> None:
    raw = bytearray(wire.to_bytes(types.Limits(few=1)))
    raw[-2:] = b"\0\x09"
    with pytest.raises(wire.DecodeError) as caught:
        wire.from_bytes(types.Limits, raw)
    assert caught.value.problem is wire.DecodeProblem.OUT_OF_RANGE
    assert (caught.value.field, caught.value.offset) == ("Limits.few", len(raw) - 2)


def test_an_unknown_enumerator_becomes_the_default_literal_or_is_refused(types: Any) -> None:
    raw = bytearray(wire.to_bytes(types.Sequences(colours=[types.Colour.RED])))
    at = 4 * 5
    assert raw[at : at + 4] == b"\0\0\0\1"
    raw[at + 4 : at + 8] = b"\0\0\0\x63"
    assert wire.from_bytes(types.Sequences, raw).colours == [types.Colour.GREEN]

    raw = bytearray(wire.to_bytes(types.Masks()))
    raw[-4:] = b"\0\0\0\x05"
    with pytest.raises(wire.DecodeError, match=r"Masks\.level"):
        wire.from_bytes(types.Masks, raw)


def test_an_older_writer_is_read_with_defaults_and_a_newer_one_by_what_is_known(types: Any) -> None:
    older = wire.from_bytes(types.Grows, bytes.fromhex("00000009"))
    assert older == types.Grows(first=9, second=2.5, third=None, fourth="x")
    newer = wire.from_bytes(types.Grows, wire.to_bytes(types.Grows(first=9)) + b"more")
    assert newer == types.Grows(first=9)
    with pytest.raises(wire.DecodeError):
        wire.from_bytes(types.Grows, b"\0\0")


def test_depth_is_bounded_where_types_hold_themselves(types: Any) -> None:
    tree = types.Tree()
    for _ in range(wire.MAX_DEPTH - 1):
        tree = types.Tree(below=[tree])
    assert wire.from_bytes(types.Tree, wire.to_bytes(tree)) == tree
    with pytest.raises(wire.DecodeError, match="nested deeper"):
        wire.from_bytes(types.Tree, wire.to_bytes(types.Tree(below=[tree])))


def test_secrets_are_not_shown(types: Any) -> None:
    assert "hunter2" not in repr(types.Words(pass_="hunter2"))


def test_values_with_arrays_compare_as_a_whole(types: Any) -> None:
    left, right = types.Sequences(reals=np.array([1.0])), types.Sequences(reals=np.array([1.0]))
    assert left == right
    right.reals = np.array([2.0])
    assert left != right


def test_units_and_ranges_stand_in_the_docs() -> None:
    source = Path(import_module("robcl.manipulator_types").__file__ or "").read_text()
    assert '"""fraction of the robot\'s own maximum [0.01 to 1.0]"""' in source
    assert '"""[m/s]"""' in source
