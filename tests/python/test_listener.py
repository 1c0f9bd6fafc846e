"""Samples of a stream that are given to a function, and the samples that a stream has kept."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import gecos
import pytest
from gecos.interface import Quality
from gecos.record import replace
from lamp import LAMP, Lamp, PlainLamp
from test_close import comes_true
from test_process import running, says

HOUR = 3600.0
LONG = 30.0  # s; how long a test waits for what must come


@pytest.fixture(params=["inproc", "shm", "lcm"])
def medium(request: pytest.FixtureRequest) -> str:
    medium: str = request.param
    return medium


@pytest.fixture
def client(place: Path) -> Iterator[gecos.Lab]:
    """The Lab of the client, which a test may close."""
    with gecos.Lab() as lab:
        yield lab


@pytest.fixture
def stream(client: gecos.Lab, server: gecos.Server, medium: str) -> gecos.Stream[float]:
    return client.create(Lamp, "LAMP", medium=medium).level.stream()


class Heard:
    """The samples that a callback got."""

    def __init__(self) -> None:
        self.samples: list[gecos.Sample[float]] = []
        self._changed = threading.Condition()

    def __call__(self, sample: gecos.Sample[float]) -> None:
        with self._changed:
            self.samples.append(sample)
            self._changed.notify_all()

    @property
    def values(self) -> list[float]:
        return [sample.value for sample in self.samples]

    def waits_for(self, value: float) -> bool:
        """Whether the last sample gets this value."""
        with self._changed:
            return self._changed.wait_for(lambda: self.values[-1:] == [value], LONG)


class Told:
    """The end of a stream, as a function was told it."""

    def __init__(self) -> None:
        self.ends: list[gecos.StreamLost] = []
        self._told = threading.Event()

    def __call__(self, end: gecos.StreamLost) -> None:
        self.ends.append(end)
        self._told.set()

    def the_only_one(self, listener: gecos.Listener[float]) -> gecos.StreamLost:
        assert self._told.wait(LONG)
        listener.close()
        (end,) = self.ends
        return end


def closes(listener: gecos.Listener[float]) -> bool:
    """Whether `close` returns although no sample comes."""
    with ThreadPoolExecutor(1) as pool:
        closing = pool.submit(listener.close)
        try:
            closing.result(LONG)
        except TimeoutError:
            return False
    return True


def test_it_gets_each_sample_once_and_in_order(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    heard = Heard()
    with stream.listen(heard):
        for value in range(1, 21):
            servant.publish_level(float(value))
            assert heard.waits_for(float(value))
    assert heard.values == [float(value) for value in range(1, 21)]
    first = heard.samples[0].sequence
    assert [sample.sequence for sample in heard.samples] == list(range(first, first + 20))
    assert not any(sample.lost for sample in heard.samples)


def test_a_slow_one_is_told_how_many_it_lost_and_nobody_else_is_slow(
    stream: gecos.Stream[float], client: gecos.Lab, servant: PlainLamp, medium: str
) -> None:
    heard, entered, go_on = Heard(), threading.Event(), threading.Event()

    def slow(sample: gecos.Sample[float]) -> None:
        heard(sample)
        entered.set()
        go_on.wait(LONG)

    quick = client.create(Lamp, "LAMP", medium=medium).level.stream()
    with stream.listen(slow):
        for value in range(1, 101):
            servant.publish_level(float(value))
            sample = quick.next(LONG)
            assert (sample.value, sample.lost) == (float(value), 0)
            assert value > 1 or entered.wait(LONG)
        go_on.set()
        assert heard.waits_for(100.0)
    assert sum(1 + sample.lost for sample in heard.samples) == 100
    assert len(heard.samples) <= 17, "the first one, and the 16 that the server keeps"


def test_it_is_told_once_that_the_server_has_closed(
    stream: gecos.Stream[float], server: gecos.Server, servant: PlainLamp
) -> None:
    heard, told = Heard(), Told()
    listener = stream.listen(heard, told)
    servant.publish_level(1.0)
    assert heard.waits_for(1.0)
    server.close()
    assert str(told.the_only_one(listener)).startswith("stream LAMP.level: the server closed")
    assert heard.values == [1.0]


SERVING = """
import gecos
from lamp import PlainLamp
gecos.serve({"LAMP": PlainLamp()}, simulated=True)
"""


@pytest.mark.parametrize(("medium", "why"), [("shm", "died"), ("lcm", "has been silent for")])
def test_it_is_told_once_that_the_server_was_killed(lab: gecos.Lab, medium: str, why: str) -> None:
    told = Told()
    with running(SERVING) as server:
        assert says(server) == "serving LAMP\n"
        stream = lab.create(Lamp, "LAMP", medium=medium).level.stream()
        listener = stream.listen(lambda sample: None, told)
        server.kill()
        assert why in str(told.the_only_one(listener))


def test_without_a_function_for_the_end_the_log_reports_it(
    stream: gecos.Stream[float], server: gecos.Server, capfd: pytest.CaptureFixture[str]
) -> None:
    listener = stream.listen(lambda sample: None)
    server.close()
    listener._thread.join(LONG)
    said = capfd.readouterr().err
    assert "the callback gets no more samples: stream LAMP.level: the server closed" in said


def test_closing_the_lab_is_told_but_not_logged(
    stream: gecos.Stream[float],
    client: gecos.Lab,
    medium: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    told = Told()
    silent = client.create(Lamp, "LAMP", medium=medium).level.stream().listen(lambda sample: None)
    listener = stream.listen(lambda sample: None, told)
    client.close()
    assert "its Lab is closed" in str(told.the_only_one(listener))
    silent._thread.join(LONG)
    assert not silent._thread.is_alive()
    assert capfd.readouterr().err == ""


def test_the_lab_may_be_closed_while_it_runs_and_by_it(
    stream: gecos.Stream[float], client: gecos.Lab, servant: PlainLamp
) -> None:
    told, closed = Told(), threading.Event()

    def close(sample: gecos.Sample[float]) -> None:
        client.close()
        closed.set()

    listener = stream.listen(close, told)
    servant.publish_level(1.0)
    assert closed.wait(LONG)
    assert "its Lab is closed" in str(told.the_only_one(listener))


def test_closing_ends_its_wait(
    stream: gecos.Stream[float], client: gecos.Lab, servant: PlainLamp, medium: str
) -> None:
    lamp = client.create(Lamp, "LAMP", medium=medium)
    for round_ in range(20):
        heard = Heard()
        listener = lamp.level.stream().listen(heard)
        if round_ % 2:  # it has read, and waits, or is about to
            servant.publish_level(float(round_))
            assert heard.waits_for(float(round_))
        assert closes(listener)
        assert not listener._thread.is_alive()
        listener.close()


def test_a_stream_that_is_closed_ends_it(stream: gecos.Stream[float]) -> None:
    listener = stream.listen(lambda sample: None)
    stream.close()
    listener._thread.join(LONG)
    assert not listener._thread.is_alive()


def test_closing_waits_for_the_callback_that_runs(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    entered, go_on = threading.Event(), threading.Event()
    done: list[float] = []

    def slow(sample: gecos.Sample[float]) -> None:
        entered.set()
        go_on.wait(LONG)
        done.append(sample.value)

    listener = stream.listen(slow)
    servant.publish_level(1.0)
    assert entered.wait(LONG)
    with ThreadPoolExecutor(1) as pool:
        closing = pool.submit(listener.close)
        assert comes_true(lambda: stream._closed)
        go_on.set()
        closing.result(LONG)
        assert done == [1.0]


def test_its_callback_may_close_it(stream: gecos.Stream[float], servant: PlainLamp) -> None:
    heard, told = Heard(), Told()

    def until_two(sample: gecos.Sample[float]) -> None:
        if sample.value == 2.0:
            listener.close()
        heard(sample)

    listener = stream.listen(until_two, told)
    for value in (1.0, 2.0):
        servant.publish_level(value)
        assert heard.waits_for(value)
    servant.publish_level(3.0)
    assert closes(listener)
    assert heard.values == [1.0, 2.0]
    assert told.ends == [], "the program itself has ended it"


@pytest.mark.parametrize("end", [ValueError("of the test"), SystemExit(3)])
def test_it_goes_on_when_its_callback_raises(
    stream: gecos.Stream[float],
    servant: PlainLamp,
    capfd: pytest.CaptureFixture[str],
    end: BaseException,
) -> None:
    heard = Heard()

    def fails_once(sample: gecos.Sample[float]) -> None:
        heard(sample)
        if sample.value == 1.0:
            raise end

    with stream.listen(fails_once):
        for value in (1.0, 2.0):
            servant.publish_level(value)
            assert heard.waits_for(value)
    said = capfd.readouterr().err
    assert "the callback of stream LAMP.level failed" in said
    assert f"{type(end).__name__}: {end}" in said


def test_it_goes_on_after_a_missed_deadline(
    client: gecos.Lab, server: gecos.Server, servant: PlainLamp, medium: str
) -> None:
    heard, told = Heard(), Told()
    stream = with_terms(client, medium, Quality(deadline_ns=5 * 10**6))
    with stream.listen(heard, told):
        assert comes_true(lambda: stream.counts.missed_deadlines > 0)
        servant.publish_level(1.0)
        assert heard.waits_for(1.0)
    assert told.ends == []


def test_a_stream_has_one(stream: gecos.Stream[float]) -> None:
    with (
        stream.listen(lambda sample: None),
        pytest.raises(RuntimeError, match=r"^stream LAMP\.level has a Listener already; open"),
    ):
        stream.listen(lambda sample: None)


# The samples that are kept.


def with_terms(
    lab: gecos.Lab, medium: str, terms: Quality, *, event: bool = False
) -> gecos.Stream[float]:
    """The level of a Lamp whose interface declares `terms` for it."""

    class DemandingLamp(Lamp):
        _gecos_interface = replace(
            LAMP,
            streams=tuple(replace(each, quality=terms, event=event) for each in LAMP.streams),
        )

    return lab.create(DemandingLamp, "LAMP", medium=medium).level.stream()


def kept(stream: gecos.Stream[float]) -> list[float]:
    return [sample.value for sample in stream.history()]


def test_a_history_has_the_newest_samples_of_the_depth_and_reads_none(
    stream: gecos.Stream[float], servant: PlainLamp
) -> None:
    assert stream.history() == []

    def keeps(*expected: int) -> bool:
        return comes_true(lambda: kept(stream) == [float(value) for value in expected])

    for last in range(1, 41):
        servant.publish_level(float(last))
        assert keeps(*range(max(1, last - 15), last + 1))
    assert stream.counts.received == 0
    assert (stream.next(LONG).value, stream.counts.received) == (25.0, 1)
    assert kept(stream)[0] == 25.0, "also those that were read"
    numbers = [(sample.sequence, sample.lost) for sample in stream.history()]
    assert numbers == [(sequence, 0) for sequence in range(25, 41)]


def test_a_history_leaves_out_samples_beyond_their_lifespan_and_damaged_ones(
    client: gecos.Lab, server: gecos.Server, servant: PlainLamp, medium: str
) -> None:
    stream = with_terms(client, medium, Quality(lifespan_ns=1200 * 10**9))
    servant.publish_level(1.0)
    servant.publish_level(2.0, stamp=time.time() - HOUR)
    servant.publish_level(3.0)
    servant.publish_damaged_level()
    servant.publish_level(5.0)
    assert comes_true(lambda: kept(stream) == [1.0, 3.0, 5.0])
    assert [sample.lost for sample in stream.history()] == [0, 1, 1]
    assert (stream.unreadable, stream.counts.expired) == (0, 0)
    assert all(0 <= sample.age < HOUR / 2 for sample in stream.history())


def test_a_history_begins_before_the_subscription_where_the_memory_is_shared(
    stream: gecos.Stream[float], client: gecos.Lab, servant: PlainLamp, medium: str
) -> None:
    for value in (1.0, 2.0, 3.0):
        servant.publish_level(value)
    assert comes_true(lambda: kept(stream) == [1.0, 2.0, 3.0])
    late = client.create(Lamp, "LAMP", medium=medium).level.stream()
    expected = [3.0] if medium == "lcm" else [1.0, 2.0, 3.0]
    assert comes_true(lambda: kept(late) == expected)
    assert late.next(LONG).value == 3.0


def test_a_history_of_an_event_begins_after_the_subscription(
    stream: gecos.Stream[float], client: gecos.Lab, servant: PlainLamp, medium: str
) -> None:
    servant.publish_level(1.0)
    assert comes_true(lambda: kept(stream) == [1.0])
    late = with_terms(client, medium, Quality(), event=True)
    servant.publish_level(2.0)
    assert comes_true(lambda: kept(late)[-1:] == [2.0])
    assert kept(late) == [2.0]


def test_a_history_stays_after_the_end_of_the_server_and_not_after_close(
    stream: gecos.Stream[float], server: gecos.Server, servant: PlainLamp
) -> None:
    servant.publish_level(1.0)
    assert comes_true(lambda: kept(stream) == [1.0])
    server.close()
    with pytest.raises(gecos.StreamLost):
        while True:
            stream.next(LONG)
    assert kept(stream) == [1.0]
    stream.close()
    assert kept(stream) == []


def test_while_another_thread_waits_a_history_is_refused(stream: gecos.Stream[float]) -> None:
    def refused() -> bool:
        try:
            stream.history()
        except RuntimeError as error:
            return str(error).startswith("stream LAMP.level: history() would block, because")
        return False

    with stream.listen(lambda sample: None):
        assert comes_true(refused)
