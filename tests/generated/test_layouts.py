"""What follows from the one layout of an operation or type, beside its codec."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from gecos import wire
from gecos.interface import Operation, method
from gecos.wire import layout
from type_values import TREE, cases


@pytest.fixture
def paint(everything: Path) -> Any:
    """`Colour paint(Colour what, sequence<string<4>> words, int32 times = 3)`."""
    return import_module("everything")._STAGE_PAINT


def test_arguments_are_values_with_json_both_ways(paint: Any) -> None:
    colour = import_module("everything_types").Colour
    plain = paint.arguments.plain((colour.RED, ["a"], 4))
    assert json.dumps(plain) == '{"what": "RED", "words": ["a"], "times": 4}'
    assert paint.arguments.made_values(plain) == (colour.RED, ["a"], 4)
    del plain["times"]
    assert paint.arguments.made_values(plain) == (colour.RED, ["a"], 3)


def test_arguments_that_are_missing_or_unknown_are_named(paint: Any) -> None:
    with pytest.raises(wire.JsonError, match="words: it is missing"):
        paint.arguments.made_values({"what": "RED"})
    with pytest.raises(wire.JsonError, match="often: unknown member; the known members are what"):
        paint.arguments.made_values({"what": "RED", "often": 1})


def test_results_are_values_with_json_both_ways(everything: Path) -> None:
    module, types = import_module("everything"), import_module("everything_types")
    level = module._STAGE_LEVEL
    assert level.plain_result(2.5) == {"result": 2.5}
    assert level.made_result({"result": 2.5}) == 2.5
    with pytest.raises(wire.JsonError, match="result: it is missing"):
        level.made_result({})
    several = types.Stage_measure_result(1.0, "x", types.Grows(7))
    plain = module._STAGE_MEASURE.plain_result(several)
    assert list(plain) == ["result", "note", "state"]
    assert module._STAGE_MEASURE.made_result(plain) == several
    assert module._DEEP_REGISTER.plain_result(None) == {}
    assert module._DEEP_REGISTER.made_result({}) is None
    with pytest.raises(wire.JsonError, match="result: unknown member"):
        module._DEEP_REGISTER.made_result({"result": 1})


@pytest.mark.parametrize("hidden", [False, True])
def test_an_optional_result_may_be_missing_in_json(hidden: bool) -> None:
    step: layout.Step = layout.optional(layout.text())
    run = method(Operation(256, "run"), gives=layout.secret(step) if hidden else step)
    assert run.made_result({}) is None
    assert run.made_result({"result": "x"}) == "x"


def test_no_refusal_shows_a_secret_number_or_what_a_secret_list_holds() -> None:
    for step, value in (
        ("B", 4711),
        (layout.ranged("i", 0, 9), 4711),
        (layout.items(layout.text(3)), ["4711"]),
        (layout.mapping("i", layout.text(3)), {1: "4711"}),
    ):
        with pytest.raises(wire.EncodeError) as caught:
            layout.secret(step).put(value, [], "Door.pin")
        assert "4711" not in str(caught.value)
        assert str(caught.value).startswith("Door.pin: ")


def test_several_results_stand_in_a_reply_without_a_size(everything: Path) -> None:
    module, types = import_module("everything"), import_module("everything_types")
    reply = b"".join(module._STAGE_MEASURE.body(types.Stage_measure_result(1.0)))
    assert reply.startswith(bytes.fromhex("3ff0000000000000"))


def test_a_layout_of_another_length_than_its_struct_is_refused() -> None:
    vector = import_module("robcl.geometry_types").Vector
    with pytest.raises(TypeError, match="Vector: 2 steps for 3 members"):
        layout.struct(0, "dd")(vector)
    assert wire.to_bytes(vector(1.0)) == bytes.fromhex("3ff0000000000000") + bytes(16)


def test_python_alone_reads_and_writes_every_vector(everything: Path) -> None:
    """Without the extension, in a process of its own."""
    program = """
import sys
sys.modules["gecos.wire._plans"] = None
from importlib import import_module
from gecos import wire
for line in sys.stdin:
    module, name, data = line.split()
    kind = getattr(import_module(module), name)
    data = bytes.fromhex(data)
    assert wire.to_bytes(wire.from_bytes(kind, data)) == data, (name, data.hex())
print("all")
"""
    chosen = [case for case in cases() if case.type.startswith("everything::") and case.bytes]
    lines = [f"everything_types {c.type.split('::')[-1]} {c.bytes.hex()}" for c in chosen]
    path = f"{TREE / 'runtime/python'}:{TREE / 'generated/python'}:{everything / 'python'}"
    done = subprocess.run(
        [sys.executable, "-c", program], input="\n".join(lines), env={"PYTHONPATH": path},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("all\n", "")
    assert len(lines) > 20
