"""Every server with every client over every medium: a call, an error, a stream during a move."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from processes import Laboratory

HERE = Path(__file__).parent / "rail"


def program(lab: Laboratory, language: str, role: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "tests" / "system" / "rail" / f"rail_{role}"]
    return [sys.executable, HERE / f"{role}.py"]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_client_and_server_agree(
    server: str, client: str, medium: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, server, "server"), ready="serving RAIL")
    checked = lab.run(*program(lab, client, "client"), medium)
    assert checked.lines[-1:] == [f"all held over {medium}"], str(checked)
