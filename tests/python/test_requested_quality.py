"""The quality that a program requests at `create`, in addition to that of the interface."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

import gecos
import pytest
from gecos.interface import Quality
from gecos.record import replace
from lamp import LAMP, Lamp, PlainLamp

HOUR = 3600.0


@pytest.mark.usefixtures("server")
def test_a_deadline_ends_a_call_whose_operation_declares_none(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    deadline = 0.05
    while not servant.burning.is_set() and deadline < 20.0:
        deadline *= 2  # on a busy machine, a short deadline may pass before the handler begins
        lamp = lab.create(Lamp, "LAMP", medium="shm", deadline=deadline)
        with gecos.actor(lamp):
            burning = lamp.burn_in()
            burning.wait(20.0)
    end = burning.exception()
    assert end is not None and end.detail is gecos.Detail.TIMED_OUT
    assert servant.interrupted.wait(10.0)


@pytest.mark.usefixtures("server")
def test_a_stream_has_the_lifespan_that_the_program_requests(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    stream = lab.create(Lamp, "LAMP", medium="shm", lifespan=1200.0).level.stream()
    servant.publish_level(1.0, stamp=time.time() - HOUR)
    servant.publish_level(2.0)
    assert stream.next(10.0).value == 2.0
    assert stream.counts.expired == 1
    servant.publish_level(3.0, stamp=time.time() - HOUR)
    assert stream.latest() is None


@pytest.mark.usefixtures("server")
def test_nan_is_no_time_to_wait(lab: gecos.Lab) -> None:
    nan = float("nan")
    lamp = lab.create(Lamp, "LAMP", medium="shm")
    waits: list[Callable[[], object]] = [
        lambda: lab.create(Lamp, "LAMP", wait=nan),
        lambda: lab.create(Lamp, "LAMP", patience=nan),
        lambda: gecos.actor(lamp, timeout=nan),
        lambda: lamp.label().wait(nan),
        lambda: lamp.label().result(nan),
        lambda: lamp.level.stream().next(nan),
        lambda: lab.objects(patience=nan),
    ]
    for wait in waits:
        with pytest.raises(ValueError, match="nan is no time to wait; give a number of seconds"):
            wait()


class BriefLamp(Lamp):
    _gecos_interface = replace(
        LAMP,
        streams=tuple(
            replace(stream, quality=Quality(lifespan_ns=1200 * 10**9)) for stream in LAMP.streams
        ),
    )


@pytest.mark.usefixtures("server")
def test_a_looser_request_changes_nothing(lab: gecos.Lab, servant: PlainLamp) -> None:
    stream = lab.create(BriefLamp, "LAMP", medium="shm", lifespan=3 * HOUR).level.stream()
    servant.publish_level(1.0, stamp=time.time() - HOUR)
    servant.publish_level(2.0)
    assert stream.next(10.0).value == 2.0


@pytest.mark.usefixtures("server")
def test_a_stream_has_the_deadline_and_the_liveliness_that_the_program_requests(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    lamp = lab.create(Lamp, "LAMP", medium="shm", deadline=0.02, liveliness="MANUAL")
    stream = lamp.level.stream()
    servant.publish_level(1.0)
    assert next(iter(stream)).value == 1.0  # before it a silence may be reported
    with pytest.raises(gecos.DeadlineMissed):
        stream.next()
    assert not stream.alive
    servant.publish_level(2.0)
    assert stream.next(10.0).value == 2.0
    assert stream.alive


@pytest.mark.usefixtures("server")
def test_a_class_that_the_medium_does_not_meet_refuses_the_create(lab: gecos.Lab) -> None:
    with pytest.raises(gecos.CreateError) as refused:
        lab.create(Lamp, "LAMP", medium="lcm", class_="HARD_REALTIME")
    assert str(refused.value) == (
        "LAMP: QOS_UNAVAILABLE: LAMP no medium meets the required quality; class=HARD_REALTIME: "
        "the medium lcm shares a queue with other programs and may lose packets"
    )
    lamp = lab.create(Lamp, "LAMP", medium="shm", class_="HARD_REALTIME")
    assert lamp.label().result() == "a lamp"


@pytest.mark.usefixtures("server")
def test_reliability_refuses_the_samples_of_a_medium_that_may_lose_some(lab: gecos.Lab) -> None:
    lamp = lab.create(Lamp, "LAMP", medium="lcm", reliability="RELIABLE")
    with pytest.raises(gecos.ConnectionFailed, match=r"over lcm: reliability=RELIABLE: "):
        lamp.level.stream()
    assert lamp.level().result() == 0.0
    lab.create(Lamp, "LAMP", medium="shm", reliability="RELIABLE").level.stream().close()


WRONG: dict[str, Callable[[gecos.Lab], object]] = {
    "'HARD' is no class; choose TIME_INDEPENDENT, SOFT_REALTIME or HARD_REALTIME, as in @qos": (
        lambda lab: lab.create(Lamp, "LAMP", class_="HARD")
    ),
    "'DEFAULT' is no reliability; choose RELIABLE or BEST_EFFORT, as in @qos": (
        lambda lab: lab.create(Lamp, "LAMP", reliability="DEFAULT")
    ),
    "'manual' is no liveliness; choose AUTOMATIC or MANUAL, as in @qos": (
        lambda lab: lab.create(Lamp, "LAMP", liveliness="manual")
    ),
    "deadline must be 1 ns or more, not 0 s; leave it out to request no deadline": (
        lambda lab: lab.create(Lamp, "LAMP", deadline=0)
    ),
    "lifespan must be 1 ns or more, not nan s; leave it out to request no lifespan": (
        lambda lab: lab.create(Lamp, "LAMP", lifespan=float("nan"))
    ),
    "latency must be 1 ns or more, not -1 s; leave it out to request no latency": (
        lambda lab: lab.create(Lamp, "LAMP", latency=-1)
    ),
    "latency must be 1 ns or more, not nan s; leave it out to request no latency": (
        lambda lab: lab.create(Lamp, "LAMP", latency=float("nan"))
    ),
    "latency must be 1 ns or more, not 9e-10 s; leave it out to request no latency": (
        lambda lab: lab.create(Lamp, "LAMP", latency=0.9e-9)
    ),
}


@pytest.mark.parametrize("text", WRONG)
def test_a_request_that_means_nothing_is_refused_at_once(lab: gecos.Lab, text: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(text)}$"):
        WRONG[text](lab)


@pytest.mark.parametrize("term", ["latency", "deadline", "lifespan"])
@pytest.mark.parametrize("wrong", ["1s", True, [0.5]])
def test_a_time_that_is_no_number_is_refused_at_once(lab: gecos.Lab, term: str, wrong: Any) -> None:
    text = f"{term} must be a number of seconds, such as 0.5, not {wrong!r}"
    with pytest.raises(TypeError, match=f"^{re.escape(text)}$"):
        lab.create(Lamp, "LAMP", **{term: wrong})
