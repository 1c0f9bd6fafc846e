"""The comparisons of `make bench-peers` and the bars that have to be met."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from candidates import Candidates, ImageCandidates
from pair import Candidate


class Figure(enum.Enum):
    P50 = "p50"
    P99 = "p99"
    RATE = "calls/s"
    LOOPS = "share of the loops"
    SHARE = "% of a core"
    CHECKS = "p50 with all checks / without"
    READABLE = "readable"
    READABLE_P99 = "readable, p99"
    WHOLE = "end to end"
    WHOLE_P99 = "end to end, p99"
    SENDING = "sending"

    @property
    def more_is_better(self) -> bool:
        return self in (Figure.RATE, Figure.LOOPS)


MOST_ROUNDS = 8 / 9
"""Share of the rounds in which a bar must be met that is judged round by round."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a table: a candidate, and who else there is meanwhile."""

    candidate: Candidate
    suffix: str = ""
    idle_clients: int = 0
    flooded: bool = False  # one more client keeps 64 calls outstanding
    beside: bool = False  # of another user, in turn with unchecked calls of the server's own user
    late: float = 0.0  # its calls are answered after so many seconds
    other_readers: int = 0  # of the images
    word: str = "trips"  # what the client is asked for; speaker.hpp has the words
    followed: bool = False  # one more client looks at the stream once in a millisecond

    @property
    def label(self) -> str:
        return self.candidate.name + self.suffix


@dataclass(frozen=True, slots=True)
class Bar:
    """A promise about `ours` beside the best of `others`: their quotient is at most `limit`, or
    at least where more is better. Without others it is the figure itself."""

    ours: str
    others: tuple[str, ...]
    limit: float
    figure: Figure = Figure.P50
    rounds: float = 0.0  # it holds in such a part of the rounds; 0: for their median


@dataclass(frozen=True, slots=True)
class Loops:
    """A program that never sleeps, on each core in use."""

    nice: int = 0
    slice_ms: float = 0.0  # 0: as long as the scheduler likes


@dataclass(frozen=True, slots=True)
class Setting:
    title: str
    lines: tuple[Line, ...]
    bars: tuple[Bar, ...]
    one_core: bool = False
    loops: Loops | None = None
    figure: Figure = Figure.P50  # the column of the table that is compared
    silent: bool = False  # a second of rest before each call
    outstanding: int = 0
    images: bool = False


def bar(ours: Line, limit: float, *others: Line, figure: Figure = Figure.P50) -> Bar:
    return Bar(ours.label, tuple(line.label for line in others), limit, figure)


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
    idle_server = Line(of.ours, ", a server whose client is silent")
    checked = Line(of.ours, ", another user, with a list, a status and an audit", beside=True)
    late = Line(of.ours, ", a client whose answers take 11 ms", late=0.011)
    python, iceoryx2_python = lines(of.ours_python, of.iceoryx2_python)
    topics = lines(of.iceoryx_topics, of.iceoryx2_topics)
    looking = Line(of.ours, ", the newest sample of a stream that does not change", word="look")
    publishing = Line(
        of.ours, ", publishing beside a reader that mostly sleeps", word="publish", followed=True
    )
    all_peers = (iceoryx_polled, iceoryx2_polled, *blocking)
    return [
        Setting(
            "two cores",
            (spin, socket, *topics, *all_peers, ours, idle),
            (
                bar(ours, 2.0, spin),
                bar(ours, 1.0, *topics),
                bar(ours, 0.6, iceoryx_polled),
                bar(idle, 5.0, spin),
                bar(idle, 0.6, iceoryx_polled),
            ),
        ),
        Setting(
            "what the checks add, two cores",
            (checked,),
            (bar(checked, 1.05, figure=Figure.CHECKS),),
            figure=Figure.CHECKS,
        ),
        Setting(
            "a busy loop on each of two cores",
            (socket, raw_lcm, *all_peers, ours),
            (bar(ours, 1.0, *all_peers, raw_lcm),),
            loops=Loops(),
        ),
        Setting(
            "one core",
            (yielding, socket, *blocking, ours),
            (bar(ours, 1.2, yielding), bar(ours, 1.0, *blocking)),
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
            (
                bar(ours, 5.0, *all_peers, figure=Figure.RATE),
                bar(ours, 0.25, spin, figure=Figure.RATE),
            ),
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
            (
                bar(flooded, 3.0, ours, figure=Figure.P99),
                bar(flooded, 8.0, figure=Figure.P99),
            ),
        ),
        Setting(
            "from Python, two cores",
            (iceoryx2_python, python),
            (bar(python, 0.3, iceoryx2_python),),
        ),
        Setting(
            "nothing to do, or waits of 11 ms",
            (idle_server, late),
            (
                bar(idle_server, 0.2, figure=Figure.SHARE),
                bar(late, 0.2, figure=Figure.SHARE),
            ),
            figure=Figure.SHARE,
        ),
        Setting(
            "streams, two cores",
            (looking, publishing),
            (bar(looking, 0.1), bar(publishing, 0.15)),
        ),
        *images(of.images),
        *beside_loops(ours, iceoryx_polled, iceoryx2_polled),
    ]


FAR_LESS = 0.2
"""Share of the time of a copy, for what is done without one."""


def images(of: ImageCandidates) -> list[Setting]:
    """Ours is as soon readable as iceoryx2's, is read whole before every peer's, and is not copied
    for further readers or for Python."""
    copy, polled, waits, python = lines(of.copy, of.ours_polled, of.ours, of.ours_python)
    iceoryx_polled, iceoryx2_polled = lines(of.iceoryx_polled, of.iceoryx2_polled)
    iceoryx2, *others = lines(of.iceoryx2, of.iceoryx, of.omniorb, of.ice, of.capnp)
    iceoryx2_python = Line(of.iceoryx2_python)
    three = Line(of.ours, ", three readers", other_readers=2)
    return [
        Setting(
            "image of 6 MB, polled",
            (copy, iceoryx_polled, iceoryx2_polled, polled, iceoryx2_python, python),
            (
                bar(polled, 2.0, iceoryx2_polled, figure=Figure.READABLE),
                bar(polled, 1.0, iceoryx_polled, iceoryx2_polled, figure=Figure.WHOLE),
                bar(python, FAR_LESS, copy, figure=Figure.READABLE),
            ),
            figure=Figure.READABLE,
            images=True,
        ),
        Setting(
            "image of 6 MB, with waits",
            (copy, *others, iceoryx2, waits, three),
            (
                bar(waits, 2.0, iceoryx2, figure=Figure.READABLE),
                bar(waits, 1.0, iceoryx2, *others, figure=Figure.WHOLE),
                bar(three, 1.2, waits, figure=Figure.SENDING),
                bar(three, FAR_LESS, copy, figure=Figure.SENDING),
            ),
            figure=Figure.READABLE,
            images=True,
        ),
    ]


def beside_loops(ours: Line, *polled: Line) -> list[Setting]:
    """Ours is not worse than polling peers, makes no fewer calls, takes no more from the loops."""
    several = []
    for priority, nice in (("equal", 0), ("lower", 19)):
        for length, slice_ms in (("long", 100.0), ("short", 0.1)):
            for cores in ("two cores", "one core"):
                several.append(
                    Setting(
                        f"loops of {priority} priority, {length} slices, {cores}",
                        (*polled, ours),
                        tuple(
                            Bar(ours.label, tuple(each.label for each in polled), 1.0, figure,
                                MOST_ROUNDS)
                            for figure in (Figure.P50, Figure.RATE, Figure.LOOPS)
                        ),
                        one_core=cores == "one core",
                        loops=Loops(nice, slice_ms),
                    )
                )  # fmt: skip
    return several
