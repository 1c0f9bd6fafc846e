"""A host on which its socket and lcm lead to two brokers."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from processes import Laboratory


@pytest.mark.parametrize("language", ["C++", "Python"])
def test_a_second_broker_says_that_names_are_unique_at_each_only(
    lab: Laboratory, language: str
) -> None:
    in_cpp = lab.build / "runtime/cpp/gecos/broker/gecos-broker"
    lab.start(in_cpp, "lcm", ready="ready")
    second: list[str | Path] = [in_cpp, "shm"]
    if language == "Python":
        second = [sys.executable, "-m", "gecos.cli", "broker"]
    told = lab.start(*second, ready="ready").wait_for("another broker answers at lcm:")
    assert "Programs use the broker at this host's local address" in told


@pytest.mark.usefixtures("here")
def test_a_program_uses_the_broker_of_its_hosts_socket(lab: Laboratory) -> None:
    broker = lab.build / "runtime/cpp/gecos/broker/gecos-broker"
    lab.start(broker, "lcm", ready="ready")
    lab.start(broker, "shm", ready="ready")
    lab.start(lab.build / "tests/system/rail/rail_server", ready="serving RAIL")
    listed = lab.run(sys.executable, "-m", "gecos.cli", "ls")
    assert "RAIL" in listed.output()
    elsewhere = lab.run(sys.executable, "-m", "gecos.cli", "ls", "--broker", "lcm")
    assert "RAIL" not in elsewhere.output()
    assert elsewhere.finish() == 0, str(elsewhere)
