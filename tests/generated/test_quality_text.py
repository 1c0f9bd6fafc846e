"""Generated code names what becomes of a degraded connection, in both languages."""

from __future__ import annotations

from pathlib import Path

import pytest
from gecos.interface import OnDegraded
from gidl.compile import compile_files
from gidl.layout import wire_layout
from gidl.targets.emit import render


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
