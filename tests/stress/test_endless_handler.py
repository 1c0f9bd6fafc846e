"""A Python handler that never returns: stop still works, and no other call moves the object."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import gecos
import pytest
from rampage import HERE, Plan, Rampage, Role
from stress.workbench import Workbench

STOP_S = 0.05
SLACK = 5.0


class Laboratory:
    """A broker and a server whose commands with salt 0 never return."""

    def __init__(self, lab: Rampage, medium: str, record: Path) -> None:
        self.medium = medium
        self._record = record
        lab.add_broker()
        words = [sys.executable, str(HERE / "programs" / "endless.py"), f"record={record}"]
        self.server: Role = lab.add("server", lambda: words)
        self.server.wait_ready()

    def events(self) -> list[str]:
        return [line.split(" ", 1)[1] for line in self._record.read_text().splitlines()]


@pytest.fixture(params=["shm", "lcm"])
def laboratory(
    request: pytest.FixtureRequest,
    build: Path,
    tmp_path: Path,
    env: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Laboratory]:
    lab = Rampage(Plan(request.param, seed=1), build, tmp_path, env)
    try:
        monkeypatch.setenv("GECOS_RUNTIME_DIR", str(lab.place))
        monkeypatch.setenv("GECOS_KEY_DIR", env["GECOS_KEY_DIR"])
        monkeypatch.delenv("GECOS_BROKER", raising=False)
        yield Laboratory(lab, request.param, tmp_path / "server.log")
    finally:
        lab.give_up()


def connect(lab: gecos.Lab, laboratory: Laboratory) -> Workbench:
    return lab.create(Workbench, "BENCH", medium=laboratory.medium)


@pytest.mark.parametrize("operation", ["tap", "file"])
def test_it_is_stopped_and_no_other_may_act_until_it_returns(
    laboratory: Laboratory, operation: str
) -> None:
    with gecos.Lab() as lab, gecos.Lab() as other_lab:
        bench, other = connect(lab, laboratory), connect(other_lab, laboratory)
        lease = gecos.actor(bench)
        endless = bench.tap(1, 0) if operation == "tap" else bench.file(1, 0, 0.0)
        waiting = bench.tap(2, 1)
        laboratory.server.program.wait_for("started 1")
        while waiting.progress().detail is not gecos.Detail.QUEUED:  # else stop overtakes it
            assert waiting.state is gecos.State.RUNNING

        began = time.monotonic()
        gecos.stop(other).result()
        assert endless.wait(SLACK) is gecos.State.COMMAND_FAILED
        assert waiting.wait(SLACK) is gecos.State.COMMAND_FAILED
        assert time.monotonic() - began < SLACK * STOP_S
        assert endless.progress().detail is gecos.Detail.STOPPED
        assert waiting.progress().detail is gecos.Detail.STOPPED
        assert gecos.holders(other).result() == [], "the lease has ended"

        with pytest.raises(gecos.LeaseRefused, match=f"the handler of '{operation}' still runs"):
            gecos.actor(other)
        assert other.weigh(4, b"still read").result() == b"still read"
        assert gecos.describe(other).result().executing == operation, "which its status says"
        assert laboratory.events() == ["start 1"]

        laboratory.server.program.signal(signal.SIGUSR1)
        with gecos.actor(other):
            assert other.tap(3, 1).result() == 1
        assert laboratory.events() == ["start 1", "finish 1", "start 3", "finish 3"]
        assert endless.progress().detail is gecos.Detail.STOPPED, "it never changes"
        del lease
