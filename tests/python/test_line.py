"""A connection that exceeds the latency that its interface demands."""

from __future__ import annotations

import re

import gecos
import pytest
from gecos.interface import OnDegraded, Quality, QualityClass
from gecos.record import replace
from lamp import LAMP, Lamp

NANOSECOND = 1  # no round trip is that short
NEVER = 3600 * 10**9


def demanding(latency_ns: int, on_degraded: OnDegraded = OnDegraded.EVENT) -> type[Lamp]:
    class DemandingLamp(Lamp):
        _gecos_interface = replace(
            LAMP,
            quality=Quality(
                line=QualityClass.SOFT_REALTIME, latency_ns=latency_ns, on_degraded=on_degraded
            ),
        )

    return DemandingLamp


@pytest.mark.usefixtures("server")
def test_a_connection_within_its_bound_is_measured_and_never_changes(lab: gecos.Lab) -> None:
    lamp = lab.create(demanding(NEVER), "LAMP")
    watch = gecos.LineWatch(lamp)
    with pytest.raises(TimeoutError, match=r"^the connection of LAMP did not change within 0\.5 s"):
        watch.next(0.5)
    state = gecos.line_state(lamp)
    assert state.bound == 3600.0
    assert state.round_trip is not None
    assert (state.degraded, state.changes) == (False, 0)


@pytest.mark.usefixtures("server")
def test_without_a_bound_nothing_is_measured(lab: gecos.Lab) -> None:
    lamp = lab.create(Lamp, "LAMP", medium="shm")
    assert gecos.line_state(lamp) == gecos.LineState("shm", 0.0, None, False, 0)


@pytest.mark.usefixtures("server")
def test_a_latency_that_the_program_accepts_is_measured_by_create(lab: gecos.Lab) -> None:
    state = gecos.line_state(lab.create(Lamp, "LAMP", medium="shm", latency=3600.0))
    assert state.bound == 3600.0
    assert state.round_trip is not None


@pytest.mark.usefixtures("server")
def test_a_medium_that_is_slower_than_the_program_accepts_is_refused(lab: gecos.Lab) -> None:
    with pytest.raises(gecos.CreateError) as refused:
        lab.create(Lamp, "LAMP", latency=1e-9)
    assert re.search(
        r"QOS_UNAVAILABLE: LAMP no medium meets the required quality; (latency=0.001us: \w+ was "
        r"measured at [0-9.]+[mu]?s(; )?){2,3}",
        str(refused.value),
    ), str(refused.value)
    assert re.search(r"latency=0.001us: lcm was measured at ", str(refused.value))


@pytest.mark.usefixtures("server")
def test_a_bound_that_no_connection_meets_gives_one_change(lab: gecos.Lab) -> None:
    lamp = lab.create(demanding(NANOSECOND), "LAMP", medium="shm")
    state = gecos.LineWatch(lamp).next(30.0)
    assert (state.degraded, state.changes) == (True, 1)
    assert state.round_trip is not None
    assert state.round_trip > state.bound
    assert lamp.label().result() == "a lamp", "the session goes on"


@pytest.mark.usefixtures("server")
def test_with_failover_a_proxy_without_a_better_medium_stays_and_says_why(lab: gecos.Lab) -> None:
    lamp = lab.create(demanding(NANOSECOND, OnDegraded.FAILOVER), "LAMP")
    watch = gecos.LineWatch(lamp)
    stays = watch.next(30.0)
    while stays.changes < 2:
        stays = watch.next(30.0)
    assert (stays.degraded, stays.changes, stays.moved_from) == (True, 2, "")
    assert re.match(rf"^LAMP stays on {stays.medium}: LAMP no medium meets", stays.why), stays.why
    assert re.search(r"latency=0.001us: \w+ was measured at", stays.why), stays.why
    assert f"{stays.medium}: the connection over this medium became too slow" in stays.why
    assert lamp.label().result() == "a lamp", "the session goes on"


@pytest.mark.usefixtures("server")
def test_with_fail_the_session_is_lost_and_says_why(lab: gecos.Lab) -> None:
    lamp = lab.create(demanding(NANOSECOND, OnDegraded.FAIL), "LAMP", medium="shm")
    changes = list(gecos.LineWatch(lamp))
    assert [each.degraded for each in changes] == [True]
    with pytest.raises(
        gecos.ConnectionFailed, match=r"for one second it has exceeded latency=0\.001us"
    ):
        lamp.dim(0.25).result()
    with pytest.raises(EOFError, match=r"^the session with LAMP is lost or closed"):
        gecos.LineWatch(lamp).next()
