"""A server that does not answer, as the command line shows it."""

from __future__ import annotations

import json
import re
import signal
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from processes import Laboratory, Program, until

GECOS = [sys.executable, "-m", "gecos.cli"]
SERVER = Path(__file__).parent / "rail" / "server.py"
OVER_LCM_ONLY = f"""
import runpy, gecos
Rail = runpy.run_path({str(SERVER)!r})["Rail"]
with gecos.Server(gecos.Lab()) as server:
    server.add("RAIL", Rail(), simulated=True, media=["lcm"])
    print("serving RAIL", flush=True)
    input()
"""
CREATE = """
import gecos
from lab.rail_sensor import RailSensor
try: gecos.Lab().create(RailSensor, "RAIL")
except gecos.CreateError as error: print(error)
"""
SINCE_WITHIN_S = 1.0
"""How exactly the broker knows since when a server is silent: it stands still between two
heartbeats, and the broker notices it at its own pace."""
SILENT = re.compile(r"silent since \d\d:\d\d:\d\d \(\d+\.\d s\)")


def start_server(lab: Laboratory, medium: str) -> Program:
    command = ["-c", OVER_LCM_ONLY] if medium == "lcm" else [SERVER]
    return lab.start(sys.executable, *command, ready="serving RAIL", listens=True)


def rail(lab: Laboratory) -> dict[str, Any]:
    done = lab.run(*GECOS, "ls", "--json")
    assert done.finish() == 0, str(done)
    (found,) = json.loads(done.output())
    assert found["name"] == "RAIL"
    return dict(found)


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_a_server_that_stands_still_is_silent_and_comes_back(
    lab_with_broker: Laboratory, medium: str
) -> None:
    lab = lab_with_broker
    server = start_server(lab, medium)
    assert rail(lab)["answers"], "it runs"
    stopped = time.time()
    server.signal(signal.SIGSTOP)
    asked = rail(lab)
    assert not asked["answers"], "asked in vain, and within a bound"
    assert asked["problem"] == "does not answer within 2 s" or SILENT.search(asked["problem"])

    until(lambda: rail(lab)["silent_since"] is not None, "the broker hears it no more")
    assert abs(rail(lab)["silent_since"] - stopped) < SINCE_WITHIN_S
    _, line = lab.run(*GECOS, "ls").lines
    assert SILENT.search(line), line
    for words in (["describe", "RAIL"], ["get", "RAIL", "beam"], ["call", "RAIL", "measure"]):
        done = lab.run(*GECOS, *words)
        assert done.finish() == 4, str(done)
        (line,) = done.lines
        assert line.startswith("gecos: RAIL: NO_SERVER: its server, ")
        assert f"pid {server.pid}, is silent since" in line and SILENT.search(line)
    done = lab.run(sys.executable, "-c", CREATE)
    assert done.finish() == 0, str(done)
    assert re.search(
        rf"NO_SERVER: the server of RAIL \(\S+, pid {server.pid}\) has been silent for \d+\.\d s:"
        rf" resume it if it is suspended \(kill -CONT {server.pid}\), end it",
        done.output(),
    ), str(done)

    server.signal(signal.SIGCONT)
    until(lambda: rail(lab)["answers"], "it is back")
    assert rail(lab)["silent_since"] is None


def test_what_is_silent_is_not_stopped_and_the_user_is_told(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    server = start_server(lab, "shm")
    server.signal(signal.SIGSTOP)
    until(lambda: rail(lab)["silent_since"] is not None, "the broker hears it no more")
    done = lab.run(*GECOS, "stop", "--all", "--json")
    assert done.finish() == 4, str(done)
    shown = json.loads(done.lines[0])
    assert shown["stopped"] == []
    assert shown["failed"][0]["name"] == "RAIL"
    said = f"gecos: RAIL was not stopped: NO_SERVER: its server, .* pid {server.pid}, is silent"
    assert any(re.match(said, line) for line in done.lines), str(done)
    assert abs(shown["failed"][0]["silent_since"] - time.time()) < 60


def test_a_server_that_has_ended_is_not_silent(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    server = start_server(lab, "shm")
    server.kill()

    def gone() -> bool:
        done = lab.run(*GECOS, "ls")
        assert "silent" not in done.output(), str(done)
        return done.output() == "no object is online"

    until(gone, "the broker has dropped it")
    done = lab.run(*GECOS, "describe", "RAIL")
    assert done.finish() == 4
    assert "no such object is online" in done.output()
