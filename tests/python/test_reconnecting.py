"""Proxies and streams that find their server again: after a kill and a pause, at another version of
the interface, and with a Lab that is closed meanwhile."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import gecos
import pytest
from gecos import Detail
from gecos.interface import Event as EventTable
from gecos.record import replace
from lamp import LAMP, LEVEL, LEVEL_STREAM, Lamp, PlainLamp, _double_result
from robcl.frames import Frame
from robcl.laser_distance_sensor import Distance, LaserDistanceSensorServant
from test_process import running, says

SERVER = """
import gecos
from lamp import PlainLamp
lamp = PlainLamp()
lamp.value = {value}
def publish(ended):
    while not ended.wait(0.02):
        lamp.publish_level(lamp.value)
gecos.serve({{"LAMP": lamp}}, simulated=True, publish=publish)
"""

OTHER_VERSION = """
import gecos
from gecos.record import replace
from lamp import LAMP, PlainLamp
class OtherLamp(PlainLamp):
    _gecos_interface = replace(
        LAMP,
        version="2.0",
        hash=2,
        operations=tuple(
            replace(each, hash=99) if each.name == "level" else each for each in LAMP.operations
        ),
    )
gecos.serve({"LAMP": OtherLamp()}, simulated=True)
"""

HEATER = """
import gecos
from lamp import Heater
class HeaterServant(gecos.Servant):
    _gecos_interface = Heater._gecos_interface
    _gecos_handlers = {}
gecos.serve({"LAMP": HeaterServant()}, simulated=True)
"""

MEDIA = pytest.mark.parametrize("medium", ["shm", "lcm"])
LOST = (gecos.CommandFailed, gecos.ConnectionFailed)
PATIENCE = 30.0


def level(lamp: Lamp) -> float:
    """A reading that is not idempotent, so it does not go on at the next server by itself."""
    return lamp.level().result(PATIENCE)


def level_stream(lamp: Lamp) -> gecos.Stream[float]:
    return lamp.level.stream()


def served(lab: gecos.Lab, servant: gecos.Servant | None = None) -> gecos.Server:
    server = gecos.Server(lab)
    server.add("LAMP", servant or PlainLamp(), simulated=True)
    return server


def freeze(server: subprocess.Popen[str]) -> None:
    """Returns when all threads of the server have stopped."""
    server.send_signal(signal.SIGSTOP)
    os.waitid(os.P_PID, server.pid, os.WSTOPPED)


def await_loss(lamp: Lamp) -> None:
    """Returns when this program knows that the server of `lamp` is gone."""
    while lamp.level().wait(PATIENCE) is not gecos.State.CONNECTION_FAILED:
        pass


def calls_until(found: gecos.Reconnecting[Lamp], value: float) -> None:
    """Calls until the answer comes from the server with this value. Calls fail meanwhile."""
    while True:
        try:
            if found.call(level) == value:
                return
        except LOST:
            continue


# A proxy ------------------------------------------------------------------------------------------


def test_the_object_need_not_be_online_before_it_is_needed(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", between_tries=0)
    with pytest.raises(gecos.CreateError, match="no object is called LAMP"):
        found.get()
    with pytest.raises(gecos.ConnectionFailed, match=r"NO_SERVER: .*no object is called LAMP"):
        found.call(level)
    with served(lab):
        assert found.call(level) == 0.0


def test_between_two_tries_the_reason_of_the_last_is_given(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", between_tries=3600.0)
    with pytest.raises(gecos.CreateError) as missing:
        found.get()
    with served(lab):
        errors = [missing.value]
        for _ in range(2):
            with pytest.raises(gecos.CreateError) as still:
                found.get()
            errors.append(still.value)
        assert len({str(each) for each in errors}) == 1
        assert len({id(each) for each in errors}) == 3, "each raise has a traceback of its own"


def test_get_waits_for_an_object_that_is_starting(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", wait=PATIENCE)
    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(found.get)
        with served(lab):
            assert level(waiting.result(PATIENCE)) == 0.0


@MEDIA
def test_a_call_goes_to_the_server_that_came_after_a_killed_one(
    lab: gecos.Lab, medium: str
) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", medium=medium, between_tries=0)
    with running(SERVER.format(value=1.0)) as first:
        assert says(first) == "serving LAMP\n"
        assert found.call(level) == 1.0
    with pytest.raises(LOST):
        found.call(level)
    with pytest.raises(gecos.ConnectionFailed):
        found.call(level)
    with running(SERVER.format(value=2.0)) as second:
        assert says(second) == "serving LAMP\n"
        assert found.call(level) == 2.0


def test_a_call_that_did_not_start_is_made_again_once_through_a_new_proxy(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", between_tries=0)
    with served(lab):
        old = found.get()
    await_loss(old)
    seen: list[Lamp] = []

    def called(lamp: Lamp) -> float:
        seen.append(lamp)
        return level(lamp)

    with served(lab):
        assert found.call(called) == 0.0
        assert seen == [old, found.get()]
        assert seen[1] is not old


@MEDIA
def test_a_frozen_server_is_given_up_and_found_when_it_goes_on(lab: gecos.Lab, medium: str) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", medium=medium, patience=0.2, between_tries=0)
    with running(SERVER.format(value=1.0)) as server:
        assert says(server) == "serving LAMP\n"
        assert found.call(level) == 1.0
        frozen = found.get()
        freeze(server)
        with pytest.raises(LOST):
            found.call(level)
        server.send_signal(signal.SIGCONT)
        calls_until(found, 1.0)
        assert found.get() is not frozen


def test_a_failure_of_the_call_itself_keeps_the_proxy(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP")
    with served(lab):
        before, calls = found.get(), 0

        def refused(lamp: Lamp) -> float:
            nonlocal calls
            calls += 1
            return lamp.dim(2.0).result()

        with pytest.raises(gecos.CommandFailed) as failed:
            found.call(refused)
        assert failed.value.detail is Detail.DENIED
        assert calls == 1
        assert found.get() is before


def test_a_proxy_that_was_replaced_already_is_not_dropped_again(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP")
    with served(lab):
        first = found.get()
        found.drop(gecos.with_deadline(first, 1.0))  # a copy has the same session
        second = found.get()
        assert second is not first
        found.drop(first)
        assert found.get() is second


@MEDIA
def test_a_status_is_never_taken_again(lab: gecos.Lab, medium: str) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", medium=medium, between_tries=0)

    def dimmed(lamp: Lamp) -> float:
        return lamp.dim(2.0).result(PATIENCE)

    with running(SERVER.format(value=1.0)) as first:
        assert says(first) == "serving LAMP\n"
        lease = gecos.actor(found.get())
        assert found.call(dimmed) == 0.5
        old = found.get()
    await_loss(old)
    with running(SERVER.format(value=4.0)) as second:
        assert says(second) == "serving LAMP\n"
        with pytest.raises(gecos.CommandFailed) as refused:
            found.call(dimmed)
        assert refused.value.detail is Detail.DENIED
        assert gecos.holders(found.get()).result() == []
        with gecos.actor(found.get()):
            assert found.call(dimmed) == 2.0
    lease.release()


def test_a_lost_command_keeps_its_outcome_and_the_new_proxy_asks_for_it(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", medium="shm", between_tries=0)
    issued: list[gecos.Command[None]] = []

    def burned_in(lamp: Lamp) -> None:
        with gecos.actor(lamp):
            issued.append(lamp.burn_in())
            while issued[0].progress().fraction < 0.25:
                issued[0].wait(0.001)
            first.kill()
            issued[0].result(PATIENCE)

    with running(SERVER.format(value=1.0)) as first:
        assert says(first) == "serving LAMP\n"
        with pytest.raises(gecos.CommandFailed) as lost:
            found.call(burned_in)
    (burning,) = issued  # a command that ran is not issued again
    assert lost.value.detail is Detail.SERVER_CRASHED
    with pytest.raises(gecos.CreateError):
        found.get()  # the proxy is dropped
    with running(SERVER.format(value=2.0)) as second:
        assert says(second) == "serving LAMP\n"
        outcome = gecos.outcome(found.get(), burning.id).result(PATIENCE)
    assert outcome.detail is Detail.OUTCOME_UNKNOWN
    assert "was restarted" in outcome.text
    assert burning.progress().detail is Detail.SERVER_CRASHED


def test_a_server_that_was_frozen_is_asked_what_became_of_a_command(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", medium="shm", patience=0.2, between_tries=0)
    with running(SERVER.format(value=1.0)) as server:
        assert says(server) == "serving LAMP\n"
        lease = gecos.actor(found.get())
        burning = found.get().burn_in()
        while burning.progress().fraction < 0.25:
            burning.wait(0.001)
        freeze(server)
        with pytest.raises(gecos.CommandFailed) as lost:
            found.call(lambda _: burning.result(PATIENCE))
        assert lost.value.detail is Detail.OUTCOME_UNKNOWN
        server.send_signal(signal.SIGCONT)
        calls_until(found, 1.0)
        while (outcome := gecos.outcome(found.get(), burning.id).result(PATIENCE)).state == 0:
            pass
        assert outcome.state is gecos.State.COMMAND_FAILED
        assert outcome.detail is not Detail.OUTCOME_UNKNOWN
        lease.release()


def test_another_version_of_the_interface_refuses_what_differs(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", between_tries=0)
    tool = gecos.ReconnectingStream(lab, Lamp, "LAMP", level_stream, between_tries=0)
    with running(SERVER.format(value=1.0)) as first:
        assert says(first) == "serving LAMP\n"
        assert found.call(level) == 1.0
        assert tool.next(PATIENCE).value == 1.0
    with running(OTHER_VERSION) as second:
        assert says(second) == "serving LAMP\n"
        with pytest.raises(LOST, match="level"):
            found.call(level)
        assert found.call(lambda lamp: lamp.label().result(PATIENCE)) == "a lamp"
        with pytest.raises(LOST, match="level"):
            while True:  # the samples of the first server may not all be read
                tool.next()
        tool.tick()
        with pytest.raises(gecos.StreamLost, match="level"):
            tool.latest()


def test_an_object_of_another_type_is_an_error_at_once(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", wait=3600.0)
    with running(HEATER) as other:
        assert says(other) == "serving LAMP\n"
        with pytest.raises(gecos.ConnectionFailed, match=r"is a test::Heater, not a test::Lamp"):
            found.call(level)
        with pytest.raises(gecos.CreateError, match=r"is a test::Heater, not a test::Lamp"):
            gecos.ReconnectingStream(lab, Lamp, "LAMP", level_stream).next()


def test_a_closed_lab_is_the_reason_that_is_given(lab: gecos.Lab) -> None:
    with served(lab), gecos.Lab() as client:
        found = gecos.Reconnecting(client, Lamp, "LAMP", between_tries=0)
        assert found.call(level) == 0.0
        client.close()
        with pytest.raises(gecos.ConnectionFailed, match="this Lab is closed"):
            found.call(level)
        with pytest.raises(gecos.CreateError, match="this Lab is closed"):
            found.get()


def test_a_lab_that_is_closed_ends_a_wait_for_the_object(lab: gecos.Lab) -> None:
    with gecos.Lab() as client, ThreadPoolExecutor(1) as pool:
        found = gecos.Reconnecting(client, Lamp, "LAMP", wait=3600.0)
        waiting = pool.submit(found.get)
        while not found._lock.locked():
            pass
        client.close()
        with pytest.raises(gecos.CreateError):
            waiting.result(PATIENCE)


def test_a_closed_one_makes_no_new_proxy(lab: gecos.Lab) -> None:
    with served(lab):
        with gecos.Reconnecting(lab, Lamp, "LAMP") as found:
            assert found.call(level) == 0.0
        with pytest.raises(gecos.CreateError, match="this Reconnecting is closed"):
            found.get()


def test_threads_share_one_proxy_before_and_after_the_loss(lab: gecos.Lab) -> None:
    found = gecos.Reconnecting(lab, Lamp, "LAMP", medium="shm", between_tries=0)
    together = threading.Barrier(4)

    def at_once() -> Lamp:
        together.wait(PATIENCE)
        return found.get()

    with ThreadPoolExecutor(4) as pool, running(SERVER.format(value=1.0)) as first:
        assert says(first) == "serving LAMP\n"
        olds = [each.result() for each in [pool.submit(at_once) for _ in range(4)]]
        assert all(each is olds[0] for each in olds)
        first.kill()
        calling = [pool.submit(calls_until, found, 2.0) for _ in range(4)]
        with running(SERVER.format(value=2.0)) as second:
            assert says(second) == "serving LAMP\n"
            for each in calling:
                each.result(PATIENCE)
            news = [each.result() for each in [pool.submit(at_once) for _ in range(4)]]
            assert all(each is news[0] for each in news)
            assert news[0] is not olds[0]


class Lds(LaserDistanceSensorServant):
    def __init__(self, value: float) -> None:
        self.value = value

    def base(self) -> Frame:
        return Frame()

    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None: ...

    def power(self, on: bool) -> None: ...

    def beam(self) -> Distance:
        return self.measure()

    def measure(self) -> Distance:
        return Distance(self.value, True)


def test_a_dynamic_proxy_is_made_from_the_model_of_each_server(lab: gecos.Lab) -> None:
    found: gecos.Reconnecting[Any] = gecos.Reconnecting(
        lab, gecos.DynamicObject, "LDS", between_tries=0
    )
    with pytest.raises(gecos.CreateError, match="no such object is online"):
        found.get()
    for value in (0.25, 0.5):
        with gecos.Server(lab) as server:
            server.add("LDS", Lds(value), simulated=True)
            assert found.call(lambda lds: lds.measure().result(PATIENCE))["value"] == value
            old = found.get()
        assert old.measure().wait(PATIENCE) is gecos.State.CONNECTION_FAILED


def test_an_object_without_a_model_is_refused_with_the_reason(lab: gecos.Lab) -> None:
    with served(lab):
        found = gecos.Reconnecting(lab, gecos.DynamicObject, "LAMP")
        with pytest.raises(gecos.CreateError, match=r"REFUSED: .*serves no model"):
            found.get()


def test_wrong_parameters_are_refused_at_once(lab: gecos.Lab) -> None:
    wrong: Any = "LAMP"
    with pytest.raises(TypeError, match="the class that gidl generated"):
        gecos.Reconnecting(lab, wrong, "LAMP")
    names: Any = ["LAMP", "TORCH"]
    with pytest.raises(TypeError, match="the name of an object must be a text"):
        gecos.Reconnecting(lab, Lamp, names)
    with pytest.raises(TypeError, match="LAMP: latency: only a class that gidl generated"):
        gecos.Reconnecting(lab, gecos.DynamicObject, "LAMP", latency=0.1)
    with pytest.raises(TypeError, match=r"LAMP: patients: `lab\.create` has no such argument"):
        gecos.Reconnecting(lab, Lamp, "LAMP", patients=0.1)  # type: ignore[call-arg]


# A stream -----------------------------------------------------------------------------------------

Stream = gecos.ReconnectingStream[Lamp, float]


def stream_of(
    lab: gecos.Lab, medium: str | None = None, patience: float = 2.0, silence: float = 1.0
) -> Stream:
    return gecos.ReconnectingStream(
        lab,
        Lamp,
        "LAMP",
        level_stream,
        medium=medium,
        patience=patience,
        between_tries=0,
        silence=silence,
    )


def heard(levels: Stream, servant: PlainLamp, value: float) -> None:
    """Publishes until `latest` has the sample."""
    while True:
        servant.publish_level(value)
        levels.tick()
        try:
            if levels.latest().value == value:
                return
        except gecos.StreamLost:
            continue


def test_tick_opens_a_stream_again_after_its_server_was_lost(lab: gecos.Lab) -> None:
    levels = stream_of(lab)
    with pytest.raises(gecos.StreamLost, match=r"^'LAMP' sent no sample yet$"):
        levels.latest()
    levels.tick()
    with pytest.raises(gecos.StreamLost, match="no object is called LAMP"):
        levels.latest()
    assert levels.proxy is None
    servant = PlainLamp()
    with served(lab, servant):
        heard(levels, servant, 11.0)
        first = levels.proxy
        assert first is not None
    with pytest.raises(gecos.StreamLost, match=r"^'LAMP' no longer sends samples$"):
        while True:
            levels.latest()
    servant = PlainLamp()
    with served(lab, servant):
        heard(levels, servant, 12.0)
        assert levels.proxy is not first
    assert levels.reopened == 1


@MEDIA
def test_a_stream_goes_on_at_the_server_that_came_after_a_killed_one(
    lab: gecos.Lab, medium: str
) -> None:
    values: list[float] = []
    reopened: list[int] = []
    with stream_of(lab, medium) as levels, ThreadPoolExecutor(1) as pool:
        both = threading.Event()
        begun = threading.Event()

        def read() -> None:
            for sample in levels:
                begun.set()
                if values[-1:] != [sample.value]:
                    values.append(sample.value)
                    reopened.append(levels.reopened)
                    assert sample.lost == 0, "how many were lost at the restart is not known"
                if sample.value == 2.0:
                    both.set()

        reading = pool.submit(read)
        with running(SERVER.format(value=1.0)) as first:
            assert says(first) == "serving LAMP\n"
            assert begun.wait(PATIENCE)
        with running(SERVER.format(value=2.0)) as second:
            assert says(second) == "serving LAMP\n"
            assert both.wait(PATIENCE)
            levels.close()
            reading.result(PATIENCE)
    assert values == [1.0, 2.0]
    assert reopened[0] == 0 and reopened[1] > 0


@MEDIA
def test_a_stream_of_a_frozen_server_goes_on_without_repeating_a_sample(
    lab: gecos.Lab, medium: str
) -> None:
    levels = stream_of(lab, medium, patience=0.2)
    with running(SERVER.format(value=1.0)) as server:
        assert says(server) == "serving LAMP\n"
        levels.next(PATIENCE)
        freeze(server)
        sequences = []
        with pytest.raises(TimeoutError, match=r"LAMP: no sample within 2\.5 s"):
            while True:
                sequences.append(levels.next(2.5).sequence)
        server.send_signal(signal.SIGCONT)
        sequences += [levels.next(PATIENCE).sequence for _ in range(5)]
        assert sequences == sorted(set(sequences))
        assert levels.reopened > 0


def test_the_newest_sample_of_a_silent_server_is_not_read_twice(lab: gecos.Lab) -> None:
    servant = PlainLamp()
    levels = stream_of(lab, silence=0.05)
    with served(lab, servant):
        servant.publish_level(1.0)
        assert levels.next(PATIENCE).value == 1.0
        while levels.reopened < 2:
            with pytest.raises(TimeoutError, match=r"^LAMP: no sample within 0\.2 s"):
                levels.next(0.2)
        servant.publish_level(2.0)
        assert levels.next(PATIENCE).value == 2.0


def test_an_old_sample_is_not_given_as_the_newest(lab: gecos.Lab) -> None:
    servant = PlainLamp()
    levels = stream_of(lab, silence=0.1)
    with served(lab, servant):
        heard(levels, servant, 1.0)
        with pytest.raises(gecos.StreamLost, match=r"^'LAMP' no longer sends samples$"):
            while True:
                levels.latest()
        before = levels.reopened
        while levels.reopened == before:
            levels.tick()
        heard(levels, servant, 2.0)


class EventLamp(Lamp):
    """A lamp whose level is an event."""

    _gecos_interface = replace(LAMP, streams=(replace(LEVEL_STREAM, event=True, rate_hz=0.0),))

    @property
    def changed(self) -> gecos.Event[float]:
        stream = EventLamp._gecos_interface.streams[0]
        return gecos.Event(self, EventTable(stream, LEVEL.result, _double_result))


class EventServant(PlainLamp):
    _gecos_interface = EventLamp._gecos_interface


def test_silence_between_two_events_is_no_loss(lab: gecos.Lab) -> None:
    servant = EventServant()
    events = gecos.ReconnectingStream(
        lab, EventLamp, "LAMP", lambda lamp: lamp.changed.stream(), between_tries=0, silence=0.01
    )
    with served(lab, servant):
        events.tick()
        with pytest.raises(TimeoutError):
            events.next(0.2)
        servant.publish_level(1.0)
        events.tick()
        sample = events.next(PATIENCE)
        assert (sample.value, sample.lost, events.reopened) == (1.0, 0, 0)
    while events.proxy is not None:
        events.tick()


def test_next_says_why_there_is_no_stream(lab: gecos.Lab) -> None:
    levels = stream_of(lab)
    for timeout in (0, 0.1):
        with pytest.raises(
            TimeoutError, match=f"LAMP: no sample within {timeout} s; .*no object is called LAMP"
        ):
            levels.next(timeout)


def test_a_reader_ends_when_its_lab_is_closed(lab: gecos.Lab) -> None:
    servant = PlainLamp()
    with served(lab, servant), gecos.Lab() as client, ThreadPoolExecutor(2) as pool:
        missing = gecos.ReconnectingStream(client, Lamp, "TORCH", level_stream)
        levels = stream_of(client)
        servant.publish_level(1.0)
        assert levels.next(PATIENCE).value == 1.0
        reading = pool.submit(list, iter(levels))
        waiting = pool.submit(missing.next)
        client.close()
        assert reading.result(PATIENCE) == []
        with pytest.raises(EOFError, match="the stream of TORCH, or its Lab, was closed"):
            waiting.result(PATIENCE)
        levels.tick()
        with pytest.raises(gecos.StreamLost, match="this Lab is closed"):
            levels.latest()


@pytest.mark.parametrize("is_served", [True, False])
def test_close_ends_the_reader_and_the_ticks(lab: gecos.Lab, is_served: bool) -> None:
    servant = PlainLamp()
    server = served(lab, servant) if is_served else gecos.Server(lab)
    with server, stream_of(lab) as levels, ThreadPoolExecutor(1) as pool:
        began = threading.Event()

        def read() -> list[gecos.Sample[float]]:
            began.set()
            return list(levels)

        reading = pool.submit(read)
        assert began.wait(PATIENCE)
        levels.close()
        assert reading.result(PATIENCE) == []
        levels.tick()
        assert levels.proxy is None
        with pytest.raises(gecos.StreamLost, match="the stream of 'LAMP' is closed"):
            levels.latest()
        with pytest.raises(EOFError):
            levels.next()


def test_other_threads_read_while_one_ticks(lab: gecos.Lab) -> None:
    servant = PlainLamp()
    levels = stream_of(lab)
    seen = threading.Barrier(4)

    def await_sample(read: Callable[[], gecos.Sample[float]]) -> float:
        while True:
            try:
                if (value := read().value) == 7.0:
                    seen.wait(PATIENCE)
                    return value
            except gecos.StreamLost:
                continue

    with served(lab, servant), ThreadPoolExecutor(3) as pool:
        reading = [pool.submit(await_sample, levels.latest) for _ in range(3)]
        while seen.n_waiting < 3:
            servant.publish_level(7.0)
            levels.tick()
        seen.wait(PATIENCE)
        assert [each.result(PATIENCE) for each in reading] == [7.0] * 3


def test_latest_is_refused_while_another_thread_waits_for_the_next(lab: gecos.Lab) -> None:
    servant = PlainLamp()
    levels = stream_of(lab, silence=PATIENCE)
    with served(lab, servant), ThreadPoolExecutor(1) as pool:
        reading = pool.submit(levels.next, PATIENCE)
        with pytest.raises(RuntimeError, match="open a stream for each thread"):
            while not reading.done():
                with contextlib.suppress(gecos.StreamLost):
                    levels.latest()
        servant.publish_level(1.0)
        assert reading.result(PATIENCE).value == 1.0
