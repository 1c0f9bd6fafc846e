"""A Lab that is closed takes all with it that somebody still has of it."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import gecos
import pytest
from gecos import Detail, State
from lamp import Lamp, PlainLamp


@pytest.fixture(params=["inproc", "shm", "lcm"])
def medium(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def visitor(lab: gecos.Lab, server: gecos.Server) -> gecos.Lab:
    """A Lab that the test closes, beside the one that serves."""
    return gecos.Lab()


@pytest.fixture
def theirs(visitor: gecos.Lab, medium: str) -> Lamp:
    return visitor.create(Lamp, "LAMP", medium=medium)


def comes_true(holds: Callable[[], bool]) -> bool:
    """Whether it does within ten seconds; the server learns of a goodbye at its own pace."""
    give_up = time.monotonic() + 10.0
    while not holds():
        if time.monotonic() > give_up:
            return False
    return True


def test_a_lease_is_given_back_though_somebody_has_it(
    visitor: gecos.Lab, theirs: Lamp, lamp: Lamp
) -> None:
    lease = gecos.actor(theirs)
    assert [holder.status.name for holder in gecos.holders(lamp).result()] == ["ACTOR"]
    visitor.close()
    assert comes_true(lambda: gecos.holders(lamp).result() == [])
    with gecos.actor(lamp):
        lease.release()
        lamp.dim(1.0).result()


def test_the_block_of_a_lab_gives_leases_back(
    server: gecos.Server, lamp: Lamp, medium: str
) -> None:
    with gecos.Lab() as visitor:
        lease = gecos.actor(visitor.create(Lamp, "LAMP", medium=medium))
    assert comes_true(lambda: gecos.holders(lamp).result() == [])
    lease.release_now()


def test_a_command_that_runs_goes_on_unobserved(
    visitor: gecos.Lab, theirs: Lamp, lamp: Lamp, servant: PlainLamp
) -> None:
    lease = gecos.actor(theirs)
    burning = theirs.burn_in()
    servant.burning.wait()
    told = threading.Event()
    burning.add_done_callback(lambda _: told.set())
    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(burning.wait)
        visitor.close()
        assert waiting.result(30.0) is State.COMMAND_FAILED
    assert told.wait(30.0)
    assert burning.progress().detail is Detail.OUTCOME_UNKNOWN
    assert gecos.holders(lamp).result()[0].releasing
    servant.finish.set()
    assert comes_true(lambda: gecos.holders(lamp).result() == [])
    assert not servant.interrupted.is_set()
    lease.release()


def test_who_waits_for_a_sample_is_told(
    visitor: gecos.Lab, theirs: Lamp, servant: PlainLamp
) -> None:
    stream = theirs.level.stream()
    begun = threading.Event()

    def read() -> None:
        for _ in stream:
            begun.set()

    with ThreadPoolExecutor(1) as pool:
        reading = pool.submit(read)
        servant.publish_level(1.0)
        assert begun.wait(10.0)
        visitor.close()
        with pytest.raises(gecos.StreamLost, match=r"LAMP\.level: its Lab is closed"):
            reading.result(30.0)


def test_a_task_that_waits_for_a_sample_is_told(
    visitor: gecos.Lab, theirs: Lamp, servant: PlainLamp
) -> None:
    stream = theirs.level.stream()

    async def read(begun: asyncio.Event) -> None:
        async for _ in stream:
            begun.set()

    async def program() -> None:
        begun = asyncio.Event()
        reading = asyncio.ensure_future(read(begun))
        servant.publish_level(1.0)
        await begun.wait()
        await asyncio.to_thread(visitor.close)
        await reading

    with pytest.raises(gecos.StreamLost):
        asyncio.run(program())


def test_nothing_is_read_afterwards(
    visitor: gecos.Lab, theirs: Lamp, lamp: Lamp, servant: PlainLamp
) -> None:
    stream, others = theirs.level.stream(), lamp.level.stream()
    servant.publish_level(1.0)
    assert (stream.next(10.0).value, others.next(10.0).value) == (1.0, 1.0)
    servant.publish_level(2.0)
    visitor.close()
    servant.publish_level(3.0)
    assert (others.next(10.0).value, others.next(10.0).value) == (2.0, 3.0)
    with pytest.raises(gecos.StreamLost):
        stream.next()
    with pytest.raises(gecos.StreamLost):
        stream.latest()


def test_a_server_of_it_goes_on(lab: gecos.Lab, medium: str) -> None:
    host = gecos.Lab()
    with gecos.Server(host) as server:
        server.add("LAMP", PlainLamp(), simulated=True)
        host.close()
        assert lab.create(Lamp, "LAMP", medium=medium).label().result() == "a lamp"
