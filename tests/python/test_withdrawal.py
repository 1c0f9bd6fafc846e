"""A server that stands still starts nothing afterwards that its callers gave up meanwhile."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator

import gecos
import pytest
from lamp import Lamp
from test_process import running, says

SERVER = """
import gecos
from lamp import PlainLamp
class NotingLamp(PlainLamp):
    def dim(self, by):
        print("dims by", by, flush=True)
        return super().dim(by)
gecos.serve({"LAMP": NotingLamp()}, simulated=True)
"""
COMMANDS = 40
PATIENCE_S = 20.0
PAUSE_S = 0.6
"""More than the 500 ms from which a server knows that it stood still, and less than the 750 ms
from which it refuses what lay unread for so long."""


@pytest.fixture
def server(lab: gecos.Lab) -> Iterator[subprocess.Popen[str]]:
    with running(SERVER) as process:
        assert says(process) == "serving LAMP\n"
        yield process


@pytest.fixture(params=["shm", "lcm"])
def medium(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def freeze(process: subprocess.Popen[str]) -> None:
    """Returns when all its threads stand still."""
    process.send_signal(signal.SIGSTOP)
    os.waitid(os.P_PID, process.pid, os.WSTOPPED)


def dims_after(process: subprocess.Popen[str], lab: gecos.Lab) -> list[str]:
    """Lets the server go on, and gives what it does until somebody else has the status and has
    dimmed by 0.5."""
    process.send_signal(signal.SIGCONT)
    lamp = lab.create(Lamp, "LAMP", wait=PATIENCE_S)
    with gecos.actor(lamp, timeout=PATIENCE_S):
        lamp.dim(0.5).result(PATIENCE_S)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, err
    return out.splitlines()


def test_nothing_starts_of_a_lab_that_was_closed_meanwhile(
    lab: gecos.Lab, server: subprocess.Popen[str], medium: str
) -> None:
    with gecos.Lab() as closed:
        lamp = closed.create(Lamp, "LAMP", medium=medium)
        lease = gecos.actor(lamp)
        freeze(server)
        issued = [lamp.dim(100.0 + number) for number in range(COMMANDS)]
    # Where the two share memory a start would be marked there, so there was none.
    proved = gecos.Detail.NOT_STARTED if medium == "shm" else gecos.Detail.OUTCOME_UNKNOWN
    assert {command.progress().detail for command in issued} == {proved}
    del lease
    assert dims_after(server, lab) == ["dims by 0.5"]


def test_nothing_starts_that_was_given_up_for_the_silence_of_the_server(
    lab: gecos.Lab, server: subprocess.Popen[str], medium: str
) -> None:
    with gecos.Lab() as waits:
        lamp = waits.create(Lamp, "LAMP", medium=medium)
        with gecos.actor(lamp):
            freeze(server)
            issued = [lamp.dim(100.0 + number) for number in range(COMMANDS)]
            for command in issued:
                command.wait(PATIENCE_S)
        proved = gecos.Detail.NOT_STARTED if medium == "shm" else gecos.Detail.OUTCOME_UNKNOWN
        assert {command.progress().detail for command in issued} == {proved}
        assert dims_after(server, lab) == ["dims by 0.5"]


CALLER = """
import signal
signal.pthread_sigmask(signal.SIG_BLOCK, {{signal.SIGUSR1}})
import gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="{medium}")
lease = gecos.actor(lamp)
print("holds", flush=True)
signal.sigwait({{signal.SIGUSR1}})
issued = [lamp.dim(100.0 + number) for number in range({commands})]
print("issued", flush=True)
signal.sigwait({{signal.SIGUSR1}})
"""


def test_nothing_starts_of_a_caller_that_was_killed_meanwhile(
    lab: gecos.Lab, server: subprocess.Popen[str], medium: str
) -> None:
    with running(CALLER.format(medium=medium, commands=COMMANDS)) as caller:
        assert says(caller) == "holds\n"
        freeze(server)
        caller.send_signal(signal.SIGUSR1)
        assert says(caller) == "issued\n"
        caller.kill()  # it has given nothing up
        caller.communicate(timeout=PATIENCE_S)
        time.sleep(PAUSE_S)  # the pause itself
        assert dims_after(server, lab) == ["dims by 0.5"]
