"""The quality that an interface declares, in generated code of both languages."""

from __future__ import annotations

from pathlib import Path

import pytest
from gecos.interface import OnDegraded
from gidl.compile import compile_files
from gidl.model.policy import Reliability
from gidl.targets.emit import render
from gidl.wire import wire_layout
from gidl.wire.events import events_as_streams


def generated(folder: Path, on_degraded: str) -> dict[str, str]:
    """Name of a generated file -> its text."""
    quality = f'class=SOFT_REALTIME, latency="5ms", on_degraded="{on_degraded}"'
    (folder / "x.gidl").write_text(f"@qos({quality}) interface Probe {{ @sensor void look(); }};")
    compiled = compile_files([str(folder / "x.gidl")], [str(folder)])
    assert not compiled.has_errors, compiled.findings
    return render(compiled.model, wire_layout.build(compiled.model), ["cpp", "python"])


@pytest.mark.parametrize("each", [each for each in OnDegraded if each is not OnDegraded.EVENT])
def test_what_an_interface_declares_is_in_the_code_of_both_languages(
    tmp_path: Path, each: OnDegraded
) -> None:
    texts = generated(tmp_path, each.name.lower())
    enumerator = f".on_degraded = gecos::qos::OnDegraded::{each.name.capitalize()}"
    assert any(enumerator in text for text in texts.values())
    assert any(f"on_degraded=_OnDegraded.{each.name}" in text for text in texts.values())


def test_the_default_is_not_written(tmp_path: Path) -> None:
    for text in generated(tmp_path, "event").values():
        assert ".on_degraded =" not in text
        assert "on_degraded=_" not in text


TANK = Path(__file__).parents[1] / "idl/corners/reliable.gidl"


def test_the_reliability_of_samples_is_that_which_is_written_where_they_are() -> None:
    compiled = compile_files([str(TANK)], [str(TANK.parent)])
    assert not compiled.has_errors, compiled.findings
    tank = compiled.model.interface("reliable::Tank")
    assert tank.qos.reliability is Reliability.RELIABLE
    assert {member.name: member.qos.reliability for member in tank.members} == {
        "capacity": Reliability.RELIABLE,
        "content": Reliability.RELIABLE,
        "level": None,
        "height": Reliability.RELIABLE,
        "flow": Reliability.RELIABLE,
        "emptied": Reliability.RELIABLE,
        "filled": Reliability.BEST_EFFORT,
    }


def test_calls_do_not_have_the_reliability_and_the_deadline_of_their_stream() -> None:
    compiled = compile_files([str(TANK)], [str(TANK.parent)])
    model = events_as_streams(compiled.model)
    texts = render(model, wire_layout.build(model), ["cpp", "python"])
    cpp = next(text for text in texts.values() if "TankInterface::streams[]" in text)
    calls, _, streams = cpp.partition("TankInterface::streams[]")
    streams = streams.partition("InterfaceDescription ")[0]
    assert calls.count("Reliability::Reliable") == 2, "of capacity and content"
    assert calls.count(".deadline") == 1, "of content"
    assert streams.count("Reliability::Reliable") == 3, "of height, flow and emptied"
    assert streams.count("Reliability::BestEffort") == 1, "of filled"
    python = next(text for text in texts.values() if "_TANK_SET_HEIGHT" in text)
    setter = python.partition("_TANK_SET_HEIGHT: ")[2].partition("_TANK_FLOW")[0]
    assert "quality" not in setter
