from __future__ import annotations

import asyncio
import copy
import math
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import gecos
import pytest
from gecos import interface
from gecos.wire import layout
from lamp import Lamp, PlainLamp


def test_a_stream_attribute_can_be_asked_once(lamp: Lamp, servant: PlainLamp) -> None:
    servant.value = 3.5
    assert lamp.level().result() == 3.5


def test_samples_come_in_order_with_stamp_and_sequence(lamp: Lamp, servant: PlainLamp) -> None:
    stream = lamp.level.stream()
    servant.publish_level(1.0, stamp=100.5)
    first = stream.next(10.0)
    assert (first.value, first.stamp, first.lost) == (1.0, 100.5, 0)
    servant.publish_level(2.0)
    second = stream.next(10.0)
    assert (second.value, second.sequence, second.lost) == (2.0, first.sequence + 1, 0)
    assert abs(second.stamp - time.time()) < 60
    assert 0 <= second.age < 60


def test_latest_is_the_newest(lamp: Lamp, servant: PlainLamp) -> None:
    stream = lamp.level.stream()
    for value in (1.0, 2.0, 3.0):
        servant.publish_level(value)
    while (sample := stream.latest()) is None or sample.value != 3.0:
        stream.next(10.0)
    assert sample.value == 3.0


def test_nothing_is_there_before_the_first_sample(lamp: Lamp) -> None:
    stream = lamp.level.stream()
    assert stream.latest() is None
    with pytest.raises(TimeoutError, match=r"stream LAMP.level: no sample within 0.001 s"):
        stream.next(0.001)


def test_a_slow_reader_is_told_how_many_it_lost(lamp: Lamp, servant: PlainLamp) -> None:
    stream = lamp.level.stream()
    servant.publish_level(0.0)
    first = stream.next(10.0)
    for value in range(1, 2001):
        servant.publish_level(float(value))
    seen = first.sequence
    while True:
        sample = stream.next(10.0)
        assert sample.sequence == seen + 1 + sample.lost
        seen = sample.sequence
        if sample.value == 2000.0:
            break
    assert seen == first.sequence + 2000


def test_a_sample_that_does_not_decode_is_passed_over(lamp: Lamp, servant: PlainLamp) -> None:
    stream = lamp.level.stream()
    servant.publish_level(1.0)
    assert stream.next(10.0).value == 1.0
    servant.publish_damaged_level()
    servant.publish_level(3.0)
    third = stream.next(10.0)
    assert (third.value, third.lost, stream.unreadable) == (3.0, 1, 1)


def test_while_the_newest_does_not_decode_there_is_no_latest(
    lamp: Lamp, servant: PlainLamp
) -> None:
    stream = lamp.level.stream()
    servant.publish_level(1.0)
    stream.next(10.0)
    servant.publish_damaged_level()
    assert stream.latest() is None
    assert stream.latest() is None
    assert stream.unreadable == 1
    servant.publish_level(3.0)
    assert stream.next(10.0).value == 3.0
    assert stream.latest() is not None


def test_iterating_waits_for_each_sample(lamp: Lamp, servant: PlainLamp) -> None:
    values = []
    servant.before_label = lambda: servant.publish_level(9.0)
    stream = lamp.level.stream()
    lamp.label().result()
    for sample in stream:
        values.append(sample.value)
        if len(values) == 3:
            break
        lamp.label().result()
    assert values == [9.0] * 3


def test_async_iteration(lamp: Lamp, servant: PlainLamp) -> None:
    async def program() -> list[float]:
        values = []
        stream = lamp.level.stream()
        servant.publish_level(0.0)
        async for sample in stream:
            values.append(sample.value)
            if len(values) == 3:
                break
            servant.publish_level(float(len(values)))
        return values

    assert asyncio.run(program()) == [0.0, 1.0, 2.0]


def test_a_stream_ends_when_its_server_closes(lamp: Lamp, server: gecos.Server) -> None:
    stream = lamp.level.stream()
    server.close()
    with pytest.raises(gecos.StreamLost):
        stream.next(10.0)


def test_who_only_asks_for_the_newest_is_told_that_the_server_is_gone(
    lamp: Lamp, servant: PlainLamp, server: gecos.Server
) -> None:
    stream = lamp.level.stream()
    servant.publish_level(1.0)
    while stream.latest() is None:
        stream.next(10.0)
    server.close()

    def ends() -> None:
        end = time.monotonic() + 10.0
        while time.monotonic() < end:
            stream.latest()

    with pytest.raises(gecos.StreamLost, match=r"stream LAMP\.level: the server closed"):
        ends()


def test_while_another_thread_waits_for_the_next_one_is_told_instead_of_waiting_too(
    lamp: Lamp, servant: PlainLamp
) -> None:
    stream = lamp.level.stream()
    got: list[float] = []
    reader = threading.Thread(target=lambda: got.append(stream.next(30.0).value))
    reader.start()
    refused = None
    while refused is None and reader.is_alive():  # it may not have begun yet
        try:
            stream.latest()
        except RuntimeError as error:
            refused = error
    assert "open a stream for each thread or task" in str(refused)
    with pytest.raises(TimeoutError, match="another thread or task was waiting"):
        stream.next(0.01)
    servant.publish_level(5.0)
    reader.join(30)
    assert got == [5.0]


def test_a_closed_stream_gives_nothing(lamp: Lamp, servant: PlainLamp) -> None:
    stream = lamp.level.stream()
    servant.publish_level(1.0)
    stream.next(10.0)
    stream.close()
    assert stream.latest() is None
    assert list(stream) == []
    with pytest.raises(EOFError, match=r"stream LAMP\.level"):
        stream.next()


def test_the_end_of_a_with_block_closes_the_stream(lamp: Lamp, servant: PlainLamp) -> None:
    with lamp.level.stream() as levels:
        servant.publish_level(0.25)
        assert levels.next(timeout=30.0).value == 0.25
    with pytest.raises(EOFError):
        levels.next(timeout=30.0)


def test_closing_a_stream_ends_who_waits_for_its_samples(lamp: Lamp, servant: PlainLamp) -> None:
    stream = lamp.level.stream()
    begun = threading.Event()

    def read() -> list[float]:
        values = []
        for sample in stream:
            values.append(sample.value)
            begun.set()
        return values

    with ThreadPoolExecutor(1) as pool:
        reading = pool.submit(read)
        servant.publish_level(1.0)
        assert begun.wait(10.0)
        stream.close()
        assert reading.result(10.0) == [1.0]


def test_publishing_before_it_is_served_says_what_to_do(servant: PlainLamp) -> None:
    with pytest.raises(gecos.ServeError, match=r"add it to a gecos\.Server first"):
        servant.publish_level(1.0)


def test_publishing_while_the_server_closes_says_that_it_is_not_served(
    server: gecos.Server, servant: PlainLamp, monkeypatch: pytest.MonkeyPatch
) -> None:
    core = servant._gecos_core
    looks = iter([core])  # the server has closed before the second look
    at_each_look = property(lambda _: next(looks, None))
    monkeypatch.setattr(PlainLamp, "_gecos_core", at_each_look, raising=False)
    servant.publish_level(1.0)
    with pytest.raises(gecos.ServeError, match="while it is not served"):
        servant.publish_level(1.0)


@pytest.mark.parametrize("stamp", [1.7e12, -1.7e12, math.nan, math.inf, 1e300, 10**30])
def test_a_stamp_that_is_no_unix_time_in_s_is_refused(
    lamp: Lamp, servant: PlainLamp, stamp: float
) -> None:
    with pytest.raises(ValueError, match=r"^stamp cannot be .* in s of Unix time"):
        servant.publish_level(1.0, stamp=stamp)
    stream = lamp.level.stream()
    servant.publish_level(2.0, stamp=1.5)
    sample = stream.next(30.0)
    assert (sample.value, sample.stamp) == (2.0, 1.5)


def test_an_attribute_says_to_open_its_stream_first(lamp: Lamp) -> None:
    level: Any = lamp.level
    why = r"level is a stream; open it first with `\.level\.stream\(\)`"
    with pytest.raises(AttributeError, match=why + "; the attribute itself has no 'latest'"):
        level.latest()
    with pytest.raises(TypeError, match=why):
        list(level)
    with pytest.raises(TypeError, match=why):
        aiter(level)
    assert not hasattr(level, "_latest")
    assert copy.copy(level)().result() == 0.0


def test_an_event_says_to_open_its_stream_first(lamp: Lamp) -> None:
    table = interface.event(
        0x1009, "lit", interface.Access.SENSOR, gives=layout.ranged("d", None), hash=0
    )
    lit: Any = gecos.Event(lamp, table)
    why = r"lit is an event; open it first with `\.lit\.stream\(\)`"
    with pytest.raises(TypeError, match=why):
        list(lit)
    with pytest.raises(AttributeError, match=why):
        lit.next()
