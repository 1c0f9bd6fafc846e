"""Inward streams: every client to every server over every medium, and the death of a sender."""

from __future__ import annotations

import sys
from pathlib import Path

import gecos
import pytest
from feeder import Dancer, Step
from processes import Laboratory, until

HERE = Path(__file__).parent / "inward"
sys.path.insert(0, str(HERE))

TRANSCRIPT = """\
without a lease: DENIED
speeds: 0.5 1 1.5
out of range: speed: 2.5 is outside [0.0, 2.0] m/s; give at most 2.0 m/s
moved: 0.100
alter: admitted 5, command_not_running 1; its command does not run
speed: admitted 3, no_status 1; the sender does not have the status, or the status has ended
remark: good bye
"""


def program(lab: Laboratory, language: str, role: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "tests" / "system" / "inward" / f"inward_{role}"]
    return [sys.executable, HERE / f"{role}.py"]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_samples_of_every_client_reach_every_server(
    server: str, client: str, medium: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, server, "server"), ready="serving")
    fed = lab.run(*program(lab, client, "client"), medium)
    assert fed.output().splitlines() == TRANSCRIPT.splitlines(), str(fed)


SENDER = """
import sys, gecos
from feeder import Dancer, Step
dancer = gecos.Lab().create(Dancer, "DANCER", medium=sys.argv[1])
lease = gecos.actor(dancer)
alter, speed = dancer.alter.writer(), dancer.speed.writer()
follow = dancer.follow()
while follow.feedback() is None: pass
alter.feeds(follow)
alter.send(Step(x=0.05, count=1))
while follow.feedback().count != 1: pass
speed.send(1.0)
print("fed", flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("server", ["C++", "Python"])
@pytest.mark.usefixtures("here")
def test_samples_of_a_sender_that_was_killed_have_no_effect(
    server: str, medium: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, server, "server"), ready="serving")
    with gecos.Lab() as mine:
        dancer = mine.create(Dancer, "DANCER", medium=medium)
        sender = lab.start(sys.executable, "-c", SENDER, medium, ready="fed", listens=True)
        sender.kill()
        until(lambda: not dancer_is_held(dancer), "its lease has ended")

        def judged() -> bool:
            assert dancer.speeds().result().size == 0
            return dancer.told("speed").result() != "admitted 0"

        # A server that suspects that it stood still judges samples later.
        until(judged, "the sample was judged")
        told = dancer.told("speed").result()
        assert "admitted 0" in told
        assert "no_status 1" in told or "session_ended 1" in told
        with gecos.actor(dancer):  # another sender takes over
            speed = dancer.speed.writer()
            speed.send(0.5)
            came: list[float] = []

            def has_come() -> bool:
                came.extend(dancer.speeds().result())
                return bool(came)

            until(has_come, "a sample of the next sender")
            assert came == [0.5]
            alter = dancer.alter.writer()
            alter.send(Step(x=0.01, count=3))
            until(lambda: list(dancer.steps().result()) == [3], "the stream takes free samples")


def dancer_is_held(dancer: Dancer) -> bool:
    return bool(gecos.holders(dancer).result())
