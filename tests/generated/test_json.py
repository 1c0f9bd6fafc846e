"""Values as JSON and back, in Python."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from gecos import wire
from gecos.errors import CommandFailed
from gecos.wire.json import dumps, loads
from gidl.model import Model
from json_cases import BOTH_REFUSE, REFUSED, WRITTEN, without_nan
from type_values import Case, cases, python_struct, python_type

WITHOUT_SECRETS = [case for case in cases() if "pass" not in case.value]


@pytest.mark.parametrize("case", WITHOUT_SECRETS, ids=lambda case: case.id)
def test_a_value_is_the_same_after_json(case: Case, model: Model, everything: Path) -> None:
    kind = python_type(model, case.type)
    value = python_struct(model, case.type, case.value)
    text = dumps(value)

    again = loads(kind, text)
    assert wire.to_bytes(again) == case.bytes
    if not isinstance(value, CommandFailed) and without_nan(case):
        assert again == value
    assert dumps(again) == text


@pytest.fixture
def types(everything: Path) -> Any:
    return import_module("everything_types")


@pytest.mark.parametrize(("kind", "text", "written"), WRITTEN, ids=str)
def test_json_is_written_as_agreed(types: Any, kind: str, text: str, written: str) -> None:
    assert json.loads(dumps(loads(getattr(types, kind), text))) == json.loads(written)


@pytest.mark.parametrize(("kind", "text", "words"), [*REFUSED, *BOTH_REFUSE], ids=lambda x: x[:60])
def test_what_is_wrong_is_said_with_its_place(types: Any, kind: str, text: str, words: str) -> None:
    with pytest.raises(wire.JsonError) as caught:
        loads(getattr(types, kind), text)
    assert str(caught.value).startswith(words)


def test_secrets_are_hidden_and_not_taken_for_themselves(types: Any) -> None:
    text = dumps(types.Words(pass_="hunter2", class_=3))
    assert "hunter2" not in text
    with pytest.raises(wire.JsonError, match="pass: the text stands for a secret"):
        loads(types.Words, text)
    assert loads(types.Words, '{"class": 3, "pass": "hunter2"}').pass_ == "hunter2"


def test_numbers_of_64_bits_are_exact(types: Any) -> None:
    value = types.Numbers(i64=-(2**63), u64=2**64 - 1)
    assert loads(types.Numbers, dumps(value)) == value
