"""A server that gives signs of life and answers nothing: whatever a Python program waits for ends
within the bound that docs/programs.md states."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import gecos
import pytest
from lab.rail_sensor import RailSensor
from processes import Laboratory, Program

pytestmark = pytest.mark.usefixtures("here")

MUTE_S = 3.0
"""After so long a server that answers nothing is given up."""
PATIENCE_S = 2.0
"""Of create."""
GRACE_S = 1.0
"""So long a reading waits for another server, when its own is given up."""
CLOSE_S = 1.0
SLACK_S = 1.0
"""For a machine that has other work."""
FAILED = {gecos.State.COMMAND_FAILED, gecos.State.CONNECTION_FAILED}


@contextmanager
def within(bound_s: float) -> Iterator[None]:
    began = time.monotonic()
    yield
    took = time.monotonic() - began
    assert took < bound_s + SLACK_S, f"took {took:.2f} s, promised are {bound_s} s"


@pytest.fixture(params=["shm", "lcm"])
def medium(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def server(lab_with_broker: Laboratory) -> Program:
    program = lab_with_broker.build / "tests/system/rail/rail_mute_server"
    return lab_with_broker.start(program, ready="serving RAIL", listens=True)


@pytest.fixture
def client(server: Program) -> Iterator[gecos.Lab]:
    lab = gecos.Lab()
    yield lab
    with within(CLOSE_S):
        lab.close()


@pytest.fixture
def rail(client: gecos.Lab, medium: str) -> RailSensor:
    return client.create(RailSensor, "RAIL", medium=medium)


def silence(server: Program) -> None:
    server.tell("be mute")
    server.wait_for("mute")


def test_it_keeps_nobody_waiting_for_a_status(server: Program, rail: RailSensor) -> None:
    silence(server)
    mute = r"^NO_SERVER: actor status of RAIL was not granted: .* has answered no call for "
    with within(MUTE_S), pytest.raises(gecos.ConnectionFailed, match=mute):
        gecos.actor(rail)


def test_it_keeps_nobody_waiting_for_a_command_that_runs(server: Program, rail: RailSensor) -> None:
    lease = gecos.actor(rail)
    ride = rail.travel(1.0)
    while ride.progress().fraction == 0.0:
        assert ride.state is gecos.State.RUNNING
    silence(server)
    with within(MUTE_S):
        assert ride.wait() is gecos.State.COMMAND_FAILED
    assert ride.progress().detail is gecos.Detail.OUTCOME_UNKNOWN, "it runs"
    with within(CLOSE_S):
        lease.release()


def test_it_keeps_nobody_waiting_for_readings(server: Program, rail: RailSensor) -> None:
    silence(server)
    asked = [gecos.describe(rail), gecos.ping(rail), gecos.holders(rail)]
    read = rail.measure()
    with within(MUTE_S):
        assert {each.wait() for each in asked} <= FAILED
    with within(GRACE_S):
        assert read.wait() in FAILED


def test_it_keeps_nobody_waiting_for_a_proxy(
    server: Program, client: gecos.Lab, medium: str
) -> None:
    silence(server)
    with within(PATIENCE_S), pytest.raises(gecos.CreateError, match=r"^RAIL: NO_SERVER: "):
        client.create(RailSensor, "RAIL", medium=medium, patience=PATIENCE_S)


def test_it_keeps_nobody_waiting_when_a_status_is_given_back(
    server: Program, rail: RailSensor
) -> None:
    lease = gecos.actor(rail)
    silence(server)
    with within(CLOSE_S):
        lease.release()
