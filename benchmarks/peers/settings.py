"""What is measured beside what, and what is promised of it."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from candidates import Candidates
from pair import Candidate


class Figure(enum.Enum):
    P50 = "p50"
    P99 = "p99"
    RATE = "calls/s"


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a table: a candidate, and who else there is meanwhile."""

    candidate: Candidate
    suffix: str = ""
    idle_clients: int = 0
    flooded: bool = False  # one more client keeps 64 calls outstanding

    @property
    def label(self) -> str:
        return self.candidate.name + self.suffix


@dataclass(frozen=True, slots=True)
class Bar:
    """What is promised of `ours` beside the best of `others`: their quotient is at most `limit`, of
    rates at least."""

    ours: str
    others: tuple[str, ...]
    limit: float


@dataclass(frozen=True, slots=True)
class Setting:
    title: str
    lines: tuple[Line, ...]
    bars: tuple[Bar, ...]
    one_core: bool = False
    busy: bool = False  # a loop that never sleeps on each core
    figure: Figure = Figure.P50
    silent: bool = False  # a second of rest before each call
    outstanding: int = 0


def bar(ours: Line, limit: float, *others: Line) -> Bar:
    return Bar(ours.label, tuple(line.label for line in others), limit)


def lines(*several: Candidate) -> tuple[Line, ...]:
    return tuple(Line(candidate) for candidate in several)


def settings(of: Candidates) -> list[Setting]:
    ours = Line(of.ours)
    idle = Line(of.ours, ", 64 idle clients", idle_clients=64)
    spin, yielding, futex, socket = lines(of.spin, of.yielding, of.futex, of.socket)
    iceoryx_polled, iceoryx2_polled = lines(*of.polled())
    blocking = lines(*of.blocking())
    raw_lcm, lcm = lines(of.raw_lcm, of.ours_lcm)
    busy_lab = Line(of.ours_lcm, ", 16 idle processes", idle_clients=16)
    flooded = Line(of.ours, ", another client floods", flooded=True)
    python, iceoryx2_python = lines(of.ours_python, of.iceoryx2_python)
    all_peers = (iceoryx_polled, iceoryx2_polled, *blocking)
    return [
        Setting(
            "two cores",
            (spin, socket, *all_peers, ours, idle),
            (
                bar(ours, 5.0, spin),
                bar(ours, 0.6, iceoryx_polled),
                bar(idle, 5.0, spin),
                bar(idle, 0.6, iceoryx_polled),
            ),
        ),
        Setting(
            "a busy loop on each of two cores",
            (socket, raw_lcm, *all_peers, ours),
            (bar(ours, 1.0, *all_peers, raw_lcm),),
            busy=True,
        ),
        Setting(
            "one core",
            (yielding, socket, *blocking, ours),
            (bar(ours, 1.5, yielding), bar(ours, 1.0, *blocking)),
            one_core=True,
        ),
        Setting(
            "one core, after a second of silence",
            (futex, ours),
            (bar(ours, 1.15, futex),),
            one_core=True,
            silent=True,
        ),
        Setting(
            "two cores, after a second of silence",
            (futex, ours),
            (bar(ours, 1.15, futex),),
            silent=True,
        ),
        Setting(
            "64 outstanding, two cores",
            (spin, socket, *all_peers, ours),
            (bar(ours, 1.5, *all_peers),),
            figure=Figure.RATE,
            outstanding=64,
        ),
        Setting(
            "lcm, two cores",
            (raw_lcm, lcm, busy_lab),
            (bar(lcm, 1.25, raw_lcm), bar(busy_lab, 1.25, raw_lcm)),
        ),
        Setting(
            "one client floods, two cores",
            (ours, flooded),
            (bar(flooded, 3.0, ours),),
            figure=Figure.P99,
        ),
        Setting(
            "from Python, two cores",
            (iceoryx2_python, python),
            (bar(python, 0.7, iceoryx2_python),),
        ),
    ]
