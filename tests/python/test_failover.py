"""Idempotent readings go on at the next server when theirs is killed."""

from __future__ import annotations

import asyncio
import signal
import time

import gecos
import pytest
from lamp import Lamp
from test_process import running, says

MUTE = """
import threading
import gecos
from lamp import PlainLamp
class Mute(PlainLamp):
    def label(self):
        print("asked", flush=True)
        threading.Event().wait()
gecos.serve({"LAMP": Mute()}, simulated=True)
"""

NEXT = """
import signal
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR1})
import gecos
from lamp import PlainLamp
print("here", flush=True)
signal.sigwait({signal.SIGUSR1})
gecos.serve({"LAMP": PlainLamp()}, simulated=True)
"""

GRACE_S = 1.0


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_what_the_killed_server_owes_the_next_one_answers(lab: gecos.Lab, medium: str) -> None:
    with running(MUTE) as first, running(NEXT) as second:
        assert says(first) == "serving LAMP\n"
        assert says(second) == "here\n"
        lamp = lab.create(Lamp, "LAMP", medium=medium)
        label = lamp.label()
        assert says(first) == "asked\n"
        level = lamp.level()  # behind it, and not idempotent
        first.kill()
        first.wait()
        second.send_signal(signal.SIGUSR1)
        assert label.result() == "a lamp"
        with pytest.raises((gecos.CommandFailed, gecos.ConnectionFailed)):
            level.result()
        assert lamp.label().result() == "a lamp"
        with pytest.raises(gecos.ConnectionFailed, match="create a new proxy"):
            lamp.level().result()


def test_awaited_it_goes_on_too(lab: gecos.Lab) -> None:
    with running(MUTE) as first, running(NEXT) as second:
        assert says(first) == "serving LAMP\n"
        assert says(second) == "here\n"
        label = lab.create(Lamp, "LAMP", medium="shm").label()
        assert says(first) == "asked\n"

        async def go_on() -> str:
            waiting = asyncio.ensure_future(_result(label))
            first.kill()
            first.wait()
            second.send_signal(signal.SIGUSR1)
            return await waiting

        assert asyncio.run(go_on()) == "a lamp"


async def _result(command: gecos.Command[str]) -> str:
    return await command


def test_when_nobody_comes_it_ends_with_grace(lab: gecos.Lab) -> None:
    with running(MUTE) as first:
        assert says(first) == "serving LAMP\n"
        label = lab.create(Lamp, "LAMP", medium="shm").label()
        assert says(first) == "asked\n"
        first.kill()
        killed = time.monotonic()
        with pytest.raises(gecos.CommandFailed, match="no server was found in time"):
            label.result()
        assert label.progress().detail is gecos.Detail.SERVER_CRASHED
        assert time.monotonic() - killed < GRACE_S + 0.5


def test_a_proxy_whose_lab_is_gone_works_but_looks_for_no_other_server(lab: gecos.Lab) -> None:
    with running(MUTE.replace("        threading", "        return 'a lamp'\n#")) as first:
        assert says(first) == "serving LAMP\n"
        lamp = gecos.Lab().create(Lamp, "LAMP", medium="shm")
        assert lamp.label().result() == "a lamp"
        assert says(first) == "asked\n"
        first.kill()
        first.wait()
        with pytest.raises(gecos.ConnectionFailed, match="keep the Lab in a variable"):
            lamp.label().result()
