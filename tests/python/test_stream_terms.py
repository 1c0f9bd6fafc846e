"""`lifespan`, `deadline` and `liveliness` of a stream, as its reader meets them."""

from __future__ import annotations

import asyncio
import time

import gecos
import pytest
from gecos.interface import Quality
from gecos.record import replace
from lamp import LAMP, Lamp, PlainLamp

HOUR = 3600.0


def with_terms(terms: Quality) -> type[Lamp]:
    """A Lamp whose interface declares `terms` for its stream."""

    class DemandingLamp(Lamp):
        _gecos_interface = replace(
            LAMP, streams=tuple(replace(stream, quality=terms) for stream in LAMP.streams)
        )

    return DemandingLamp


def opened(lab: gecos.Lab, terms: Quality) -> gecos.Stream[float]:
    return lab.create(with_terms(terms), "LAMP").level.stream()


@pytest.mark.usefixtures("server")
def test_a_sample_older_than_its_lifespan_is_never_returned(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    stream = opened(lab, Quality(lifespan_ns=1200 * 10**9))
    servant.publish_level(1.0)
    assert stream.next(10.0).value == 1.0
    servant.publish_level(2.0, stamp=time.time() - HOUR)
    servant.publish_level(3.0)
    sample = stream.next(10.0)
    assert (sample.value, sample.lost) == (3.0, 1)
    assert stream.counts == gecos.StreamCounts(
        received=2, lost=0, skipped=0, expired=1, missed_deadlines=0
    )
    servant.publish_level(4.0, stamp=time.time() - HOUR)
    with pytest.raises(TimeoutError):
        stream.next(0.2)
    assert stream.latest() is None
    assert stream.counts.expired == 2
    stream.close()
    assert stream.counts.expired == 2, "also after the end"


@pytest.mark.usefixtures("server")
def test_a_silence_is_reported_once_and_the_stream_goes_on(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    stream = opened(lab, Quality(deadline_ns=20 * 10**6))
    with pytest.raises(
        gecos.DeadlineMissed, match=r"^stream LAMP\.level: no sample came within its deadline"
    ):
        stream.next()
    assert stream.counts.missed_deadlines >= 1
    with pytest.raises(TimeoutError) as told:
        stream.next(0.001)
    assert not isinstance(told.value, gecos.DeadlineMissed)
    assert stream.alive, "its process lives"
    servant.publish_level(1.0)
    assert stream.next(10.0).value == 1.0
    with pytest.raises(gecos.DeadlineMissed):
        stream.next()


@pytest.mark.usefixtures("server")
def test_a_writer_that_vouches_for_itself_is_dead_while_it_is_silent(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    stream = opened(lab, Quality(deadline_ns=20 * 10**6, manual_liveliness=True))
    servant.publish_level(1.0)
    assert next(iter(stream)).value == 1.0  # before it a silence may be reported
    with pytest.raises(gecos.DeadlineMissed):
        stream.next()
    assert not stream.alive
    assert stream.latest() is None
    servant.publish_level(2.0)
    assert stream.next(10.0).value == 2.0
    assert stream.alive
    stream.close()
    assert not stream.alive


@pytest.mark.usefixtures("server")
def test_loops_go_on_after_a_silence(lab: gecos.Lab, servant: PlainLamp) -> None:
    stream = opened(lab, Quality(deadline_ns=10**6))
    with pytest.raises(gecos.DeadlineMissed):
        stream.next()
    servant.publish_level(1.0)
    assert next(iter(stream)).value == 1.0

    async def silence_then_sample() -> float:
        awaited = asyncio.ensure_future(anext(aiter(stream)))
        missed = stream.counts.missed_deadlines
        while stream.counts.missed_deadlines == missed:  # its thread waits beyond the deadline
            await asyncio.sleep(0)
        servant.publish_level(2.0)
        return (await awaited).value

    assert asyncio.run(silence_then_sample()) == 2.0
