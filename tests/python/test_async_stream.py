"""`async for` over a stream: whose thread waits, and what a cancelled reader leaves behind."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor

import gecos
import pytest
from lamp import Lamp, PlainLamp


@pytest.fixture
def stream(lamp: Lamp) -> gecos.Stream[float]:
    return lamp.level.stream()


async def read_one(stream: gecos.Stream[float]) -> gecos.Sample[float]:
    return await anext(aiter(stream))


async def waiting(stream: gecos.Stream[float]) -> asyncio.Task[gecos.Sample[float]]:
    """A task whose thread waits for the next sample."""
    task = asyncio.ensure_future(read_one(stream))
    while not stream._occupied():
        await asyncio.sleep(0)
    return task


async def given(
    stream: gecos.Stream[float], servant: PlainLamp, value: float
) -> asyncio.Task[gecos.Sample[float]]:
    """A task whose thread has taken this sample, while the task could not go on yet."""
    before = stream._read
    task = await waiting(stream)
    servant.publish_level(value)
    while stream._read == before or stream._reading.locked():
        pass
    assert not task.done()
    return task


async def cancel(task: asyncio.Task[gecos.Sample[float]]) -> None:
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task


def readers() -> set[threading.Thread]:
    return {thread for thread in threading.enumerate() if thread.name == "gecos-reader"}


class TakenPool(ThreadPoolExecutor):
    """The threads of an event loop that has none left."""

    def submit(self, *_: object, **__: object) -> None:  # type: ignore[override]
        raise AssertionError("it was asked for a thread")


def test_reading_takes_no_thread_of_the_event_loop(lamp: Lamp, servant: PlainLamp) -> None:
    async def program() -> list[float]:
        asyncio.get_running_loop().set_default_executor(TakenPool())
        streams = [lamp.level.stream() for _ in range(40)]
        servant.publish_level(4.0)
        return [sample.value for sample in await asyncio.gather(*map(read_one, streams))]

    assert asyncio.run(program()) == [4.0] * 40


def test_a_reader_that_has_left_leaves_no_thread(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> set[threading.Thread]:
        before = readers()
        servant.publish_level(1.0)
        async for _ in stream:
            ours = readers() - before
            break
        task = await waiting(stream)
        ours |= readers() - before
        await cancel(task)
        return ours

    threads = asyncio.run(program())
    assert len(threads) == 2
    for thread in threads:
        thread.join(30)
        assert not thread.is_alive()


def test_a_sample_that_comes_after_its_reader_was_cancelled_goes_to_the_next(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        for value in (1.0, 2.0, 3.0):
            await cancel(await waiting(stream))
            servant.publish_level(value)  # the thread still waits for a moment
            sample = await read_one(stream)
            assert (sample.value, sample.lost) == (value, 0)

    asyncio.run(program())


def test_a_sample_that_came_just_before_its_reader_was_cancelled_goes_to_the_next(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        await cancel(await given(stream, servant, 1.0))

    asyncio.run(program())
    servant.publish_level(2.0, stamp=5.0)
    first, second = stream.next(10.0), stream.next(10.0)
    assert [(first.value, first.lost), (second.value, second.lost)] == [(1.0, 0), (2.0, 0)]
    assert 0 <= first.age < 60 < second.age


def test_the_newest_stays_the_newest_when_its_reader_was_cancelled(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        await cancel(await given(stream, servant, 1.0))

    asyncio.run(program())
    newest = stream.latest()
    assert newest is not None
    assert (newest.value, newest.lost) == (1.0, 0)
    with pytest.raises(TimeoutError):
        stream.next(0.0)


def test_a_sample_of_a_cancelled_reader_beyond_which_somebody_has_read_is_lost(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        servant.publish_level(0.0)
        assert (await read_one(stream)).value == 0.0
        task = await given(stream, servant, 1.0)
        servant.publish_level(2.0)
        assert stream.next(10.0).value == 2.0
        await cancel(task)

    asyncio.run(program())
    servant.publish_level(3.0)
    third = stream.next(10.0)
    assert (third.value, third.lost) == (3.0, 1)


def test_who_asks_for_the_newest_loses_the_one_of_a_cancelled_reader(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        servant.publish_level(0.0)
        assert (await read_one(stream)).value == 0.0
        await cancel(await given(stream, servant, 1.0))

    asyncio.run(program())
    servant.publish_level(2.0)
    servant.publish_level(3.0)
    newest = stream.latest()
    assert newest is not None
    assert (newest.value, newest.lost) == (3.0, 2)


def test_after_a_cancelled_reader_the_newest_is_there_at_once(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        servant.publish_level(1.0)
        assert (await read_one(stream)).value == 1.0
        await cancel(await waiting(stream))
        newest = stream.latest()
        assert newest is not None
        assert newest.value == 1.0

    asyncio.run(program())


def test_a_closed_stream_gives_nothing_of_a_cancelled_reader_either(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        await cancel(await given(stream, servant, 1.0))
        stream.close()
        assert [sample async for sample in stream] == []

    asyncio.run(program())


def test_who_was_interrupted_may_go_on_with_the_same_iterator(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    async def program() -> None:
        samples = aiter(stream)
        for value in (1.0, 2.0):
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.001):
                    await anext(samples)
            servant.publish_level(value)
            sample = await anext(samples)
            assert (sample.value, sample.lost) == (value, 0)

    asyncio.run(program())
