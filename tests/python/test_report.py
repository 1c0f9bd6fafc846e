"""Text that comes from other programs does not command the terminal."""

from __future__ import annotations

import json

import pytest
from gecos.cli import report
from gecos.dynamic_client.model import Attribute, Interface, Model, Operation, Value
from gecos.dynamic_client.type_text import parse_type
from gecos_idl.object_types import Description, RunningHandler

CLEAR = "\x1b[2J"  # "erase the screen" in seven bits
CLEAR_C1 = "\x9b2J"  # the same in eight bits
HOSTILE = f"a{CLEAR}{CLEAR_C1}\x7f"


def printed(capsys: pytest.CaptureFixture[str]) -> str:
    text = capsys.readouterr().out
    commands = [c for c in text if not (c.isprintable() or c == "\n")]
    assert not commands, text
    return text


def test_the_program_that_runs_a_handler(capsys: pytest.CaptureFixture[str]) -> None:
    handler = RunningHandler(operation="move", user=HOSTILE, host=HOSTILE, program=HOSTILE)
    report.description(Description(name=HOSTILE, handlers=[handler]))
    assert r"called by a\x1b[2J\x9b2J\x7f on " in printed(capsys)


@pytest.mark.parametrize("indent", [None, 2])
def test_a_value_with_members_stays_valid_json(
    indent: int | None, capsys: pytest.CaptureFixture[str]
) -> None:
    value = {"text": HOSTILE, "umlaut": "ü"}
    if indent is None:
        report.Samples(as_json=False, unit="", replace=True).show({"value": value})
    else:
        report.value(value, "")
    text = printed(capsys)
    assert json.loads(text) == value
    assert r"\u009b2J\u007f" in text
    assert "ü" in text


def test_the_types_units_and_defaults_of_members(capsys: pytest.CaptureFixture[str]) -> None:
    spoiled = f'sequence<@unit("{HOSTILE}") double>'
    width = Value(
        name="width", type=spoiled, use=parse_type(spoiled), unit=HOSTILE, default=HOSTILE
    )
    members = (
        Attribute(name="jaws", interface="a::B", result=width),
        Operation(name="open", interface="a::B", parameters=(width,)),
    )
    own = Interface(name="a::B", members=members)
    report.members(Model("a::B", {"a::B": own}, {}, frozenset()), {"jaws": HOSTILE})
    text = printed(capsys)
    assert "jaws: sequence" in text
    assert r"\x9b2J" in text
    assert r'= "a\u001b[2J\u009b2J\u007f"' in text


def test_a_number_without_a_unit_is_printed_alone(capsys: pytest.CaptureFixture[str]) -> None:
    report.value(0.5, "1")
    report.value(0.5, "m")
    assert capsys.readouterr().out.splitlines() == ["0.5", "0.5 m"]
