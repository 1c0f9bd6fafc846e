"""Ctrl-C in the programs of docs/own-program.md, which says what becomes of the motion."""

from __future__ import annotations

import json

import pytest
from pages import Reader
from test_pages import did

BEHIND = '{"goal": {"position": {"x": -0.4, "y": -0.3, "z": 0.25}, "orientation": {"y": 1}}}'


def finishes_after_ctrl_c(reader: Reader, program: str) -> bool:
    """Presses Ctrl-C while the program moves the arm to y = 0.2. Does the motion finish?"""
    mine = reader.terminals["2"]
    did(mine, f"gecos call RX90 move '{BEHIND}'")
    mine.type(program)
    mine.see(["…%"])
    mine.interrupt()
    did(mine, "while gecos describe RX90 | grep -q 'executing *move'; do :; done")
    (tool,) = did(mine, "gecos get RX90 tool --json")
    y: float = json.loads(tool)["value"]["position"]["y"]
    return abs(y - 0.2) < 0.001


@pytest.mark.timeout(300)
def test_a_motion_finishes_without_its_python_program_and_ends_with_its_cpp_program(
    reader: Reader,
) -> None:
    reader.follow("docs/own-program.md")
    assert finishes_after_ctrl_c(reader, "python approach.py")
    assert not finishes_after_ctrl_c(reader, "stdbuf -oL ./build/approach")
