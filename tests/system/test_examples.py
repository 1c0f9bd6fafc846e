"""The numbered examples do what they say, in every pairing of languages and media."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from processes import Laboratory

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def read_distance(lab: Laboratory, language: str, role: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "examples" / f"lds_{role}"]
    return [sys.executable, EXAMPLES / "01_read_distance" / f"{role}.py"]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_read_distance(server: str, client: str, medium: str, lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(*read_distance(lab, server, "server"), ready="LASER")
    asked = lab.run(*read_distance(lab, client, "client"), medium)
    assert asked.finish() == 0, str(asked)
    distance = re.fullmatch(r"(0\.\d{3}) m", asked.output())
    assert distance and 0.4 <= float(distance[1]) <= 0.6, str(asked)


@pytest.mark.parametrize("client", ["C++", "Python"])
def test_read_distance_without_a_server_says_what_is_missing(
    client: str, lab_with_broker: Laboratory
) -> None:
    asked = lab_with_broker.run(*read_distance(lab_with_broker, client, "client"))
    assert asked.finish() != 0
    assert "LASER" in asked.output() and "NO_SERVER" in asked.output(), str(asked)
    assert "Traceback" not in asked.output(), str(asked)


def grip_block(lab: Laboratory, language: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "examples" / "grip_block"]
    return [sys.executable, EXAMPLES / "02_grip_block" / "grip_block.py"]


@pytest.mark.parametrize("language", ["C++", "Python"])
def test_grip_block_says_what_it_takes(language: str, lab: Laboratory) -> None:
    helped = lab.run(*grip_block(lab, language), "--help")
    assert helped.finish() == 0, str(helped)
    assert "usage: grip_block" in helped.output()
    assert "lifts it by 200 mm" in helped.output() and "--leave" in helped.output()

    refused = lab.run(*grip_block(lab, language), "--lift")
    assert refused.finish() == 2, str(refused)
    assert "--lift" in refused.output() and "usage: grip_block" in refused.output()


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("language", ["C++", "Python"])
def test_grip_block_over_each_medium(
    language: str, medium: str, lab_with_devices: Laboratory
) -> None:
    lab = lab_with_devices
    gripped = lab.run(*grip_block(lab, language), medium)
    assert gripped.finish() == 0, str(gripped)
    assert gripped.lines[-1] == "lift: FINISHED", str(gripped)
