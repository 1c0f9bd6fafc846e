"""A proxy with `on_degraded="failover"` moves to another medium while a stream is read."""

from __future__ import annotations

import itertools
import re
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import gecos
import pytest
from gecos.interface import OnDegraded, Quality, QualityClass
from gecos.record import replace
from lab.rail_sensor import RailSensor
from processes import Laboratory, Program

SERVER = f"""
import runpy, threading, time, gecos
rail = runpy.run_path({str(Path(__file__).parent / "rail" / "server.py")!r})["Rail"]()
def measure():
    while True:
        rail.publish_beam(rail.beam())
        time.sleep(0.01)
with gecos.Server(gecos.Lab()) as server:
    server.add("RAIL", rail, simulated=True, media=["shm", "lcm"])
    threading.Thread(target=measure, daemon=True).start()
    print("serving RAIL", flush=True)
    input()
"""
BOUND_S = 0.1
STANDSTILL_S = 0.3  # longer than the bound, and shorter than the silence that ends a session
PATIENCE_S = 30.0


class MobileRail(RailSensor):
    _gecos_interface = replace(
        RailSensor._gecos_interface,
        quality=Quality(
            line=QualityClass.SOFT_REALTIME,
            latency_ns=round(BOUND_S * 1e9),
            on_degraded=OnDegraded.FAILOVER,
        ),
    )


@contextmanager
def hesitating(server: Program, rail: RailSensor) -> Iterator[None]:
    """Makes `server` stand still again and again, until the connection of `rail` is degraded: each
    answer is late. Then the server runs, so that another medium is found fast enough."""
    over = threading.Event()

    def hesitate() -> None:
        while not over.wait(0.003):
            state = gecos.line_state(rail)
            if state.degraded or state.moved_from:
                continue
            server.signal(signal.SIGSTOP)
            over.wait(STANDSTILL_S)
            server.signal(signal.SIGCONT)

    thread = threading.Thread(target=hesitate)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@pytest.mark.usefixtures("here")
def test_calls_and_samples_go_on_over_the_other_medium(lab_with_broker: Laboratory) -> None:
    server = lab_with_broker.start(sys.executable, "-c", SERVER, ready="serving RAIL", listens=True)
    with gecos.Lab() as lab:
        rail = lab.create(MobileRail, "RAIL", patience=PATIENCE_S)
        assert gecos.line_state(rail).medium == "shm"
        with rail.beam.stream() as stream, hesitating(server, rail):
            read = [stream.next(PATIENCE_S)]
            deadline = time.monotonic() + PATIENCE_S
            while not (state := gecos.line_state(rail)).moved_from:
                assert time.monotonic() < deadline, state
                read.append(stream.next(PATIENCE_S))
            moved_after = len(read)
            while len(read) < moved_after + 50:
                read.append(stream.next(PATIENCE_S))
            counts = stream.counts
        assert (state.medium, state.moved_from) == ("lcm", "shm")
        assert re.match(
            r"^RAIL has moved from shm to lcm: RAIL over shm: the round trip took [^;]*; for "
            r"one second it has exceeded latency=100ms",
            state.why,
        ), state.why
        for before, after in itertools.pairwise(read):
            assert after.sequence == before.sequence + 1 + after.lost, "each once and in order"
        assert (counts.received, counts.lost) == (len(read), sum(each.lost for each in read))
        assert rail.measure().result().valid, "calls go over the other medium, too"
