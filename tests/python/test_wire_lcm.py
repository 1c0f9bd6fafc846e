"""LCM's own tools read what we write, and write what we read."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from gecos import wire
from robcl.frames import Frame

ROOT = Path(__file__).parent.parent.parent
FRAME_LCM = """
package gecos_wire_test;
struct vector { double x; double y; double z; }
struct quaternion { double w; double x; double y; double z; }
struct frame { vector position; quaternion orientation; }
"""


def vectors(name: str) -> Any:
    return json.loads((ROOT / "tests" / "vectors" / name).read_text(encoding="utf-8"))


def generated(source: Path, folder: Path, module: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The Python module that lcm-gen makes of a .lcm file."""
    lcm_gen = Path(sys.executable).parent / "lcm-gen"
    subprocess.run([lcm_gen, "--python", "--ppath", folder, source], check=True)
    monkeypatch.syspath_prepend(str(folder))
    sys.modules.pop(module.partition(".")[0], None)
    return importlib.import_module(module)


def signed(number: int, bits: int) -> int:
    return number - 2**bits if number >= 2 ** (bits - 1) else number


def test_lcm_gen_reads_and_writes_our_packets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # `gecos` is our own package's name, so LCM's half is generated under another one.
    text = (ROOT / "docs" / "protocol-packet.lcm").read_text(encoding="utf-8")
    source = tmp_path / "packet.lcm"
    source.write_text(text.replace("package gecos;", "package gecos_lcm;"), encoding="utf-8")
    packet = generated(source, tmp_path, "gecos_lcm", monkeypatch).packet
    for case in vectors("packet.json")["accepted"]:
        data = bytes.fromhex(case["bytes"])
        message = packet.decode(data)
        for field in ("version", "kind", "flags", "reserved", "deadline_ns"):
            assert getattr(message, field) == case[field], field
        for field in ("session", "counter", "acknowledged", "epoch"):
            assert getattr(message, field) == signed(case[field], 64), field
        assert message.code == signed(case["code"], 32)
        assert (message.body.hex(), message.tag.hex()) == (case["body"], case["tag"])
        assert message.encode() == data


def test_lcm_gen_reads_and_writes_our_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "frame.lcm"
    source.write_text(FRAME_LCM, encoding="utf-8")
    frame = generated(source, tmp_path, "gecos_wire_test", monkeypatch).frame
    for case in vectors("frames.json")["encoded"]:
        ours = wire.from_bytes(Frame, bytes.fromhex(case["bytes"]))
        theirs = frame.decode(wire.to_message(ours))
        assert (theirs.position.x, theirs.position.y, theirs.position.z) == tuple(ours.position)
        turn = theirs.orientation
        assert (turn.w, turn.x, turn.y, turn.z) == ours.quaternion()
        assert wire.from_message(Frame, theirs.encode()) == ours
