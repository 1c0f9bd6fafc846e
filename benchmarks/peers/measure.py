"""Rounds: everything that stands in one table is measured in turn, in every round anew."""

from __future__ import annotations

import contextlib
import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

from busy_loops import BusyLoops
from judge import Measured, Rounds
from pair import Broken, Pair, Process
from settings import Figure, Line, Setting


@dataclass(frozen=True, slots=True)
class Pace:
    """How much is measured."""

    rounds: int
    seconds: float  # measured for each line in each round
    rests: int  # calls after a second of silence, in every round


@dataclass(slots=True)
class Run:
    """The figures of one setting."""

    rounds: Rounds
    repeated: dict[str, int] = field(default_factory=dict)  # by line: how often it failed


OTHER_USER = "daemon"
"""A user of every host whom the server of the benchmark admits by a list."""

TURNS = 20
"""How often calls with and without checks take turns in a round."""

TRIES = 3
"""Attempts to measure a candidate in a round before it counts as failed."""


def run(setting: Setting, there: tuple[Line, ...], pace: Pace, env: dict[str, str]) -> Run:
    """Measures those lines of `setting` that are there, round by round.

    What fails is repeated and counted. A peer that fails three times in a round is left out from
    then on, and of what is given; ours that does ends the run.
    """
    done = Run({line.label: [] for line in there})
    cores = sorted(os.sched_getaffinity(0))
    with BusyLoops(setting.loops, cores[: 1 if setting.one_core else 2]) as loops:
        for number in range(1, pace.rounds + 1):
            print(f"bench-peers: {setting.title}, round {number}", file=sys.stderr, flush=True)
            for line in there:
                if line.label not in done.rounds:
                    continue
                try:
                    once = partial(_once, setting, line, pace, cores, env, loops)
                    measured = _repeatedly(done, line, once)
                except Broken:
                    if not line.candidate.peer:
                        raise
                    del done.rounds[line.label]
                else:
                    done.rounds[line.label].append(measured)
    return done


def _repeatedly(done: Run, line: Line, measure: Callable[[], Measured]) -> Measured:
    for left in reversed(range(TRIES)):
        try:
            return measure()
        except Broken as why:
            done.repeated[line.label] = done.repeated.get(line.label, 0) + 1
            print(f"bench-peers: {line.label} BROKE: {why}", file=sys.stderr, flush=True)
            if not left:
                raise
    raise AssertionError


def _once(
    setting: Setting,
    line: Line,
    pace: Pace,
    cores: list[int],
    env: dict[str, str],
    loops: BusyLoops,
) -> Measured:
    mine, servers = cores[0], cores[0 if setting.one_core else 1]
    with contextlib.closing(Pair(line.candidate, servers, env)) as pair:
        if setting.images:
            return _images(pair, line, pace.seconds, mine)
        for _ in range(line.idle_clients):
            pair.client(cores)
        client = pair.client([mine])
        _ask(client, "trips 0.1")  # warm
        if setting.figure is Figure.SHARE:
            return _share(client, pair.server, line.late, pace.seconds)
        if line.beside:
            other = pair.client([mine], OTHER_USER)
            return _beside(other, client, pace.seconds)
        if setting.outstanding:
            _ask(client, f"outstanding {setting.outstanding} {pace.seconds / 4}")
            (rate,) = _ask(client, f"outstanding {setting.outstanding} {pace.seconds}")
            return Measured(rate=rate)
        if setting.silent:
            return _trips(_ask(client, f"silent 1.0 {pace.rests}"))
        loops.begin()
        if not line.flooded and not line.followed:
            measured = _trips(_ask(client, f"{line.word} {pace.seconds}"), pace.seconds)
            return replace(measured, loops=loops.share())
        other = pair.client(cores[:2] if line.flooded else [mine])
        asked = "outstanding 64" if line.flooded else "follow"
        other.say(f"{asked} {pace.seconds + 0.2}")  # begins before, ends after
        _ask(client, f"{line.word} 0.1")
        measured = _trips(_ask(client, f"{line.word} {pace.seconds}"))
        other.line()
        return measured


def _beside(checked: Process, unchecked: Process, seconds: float) -> Measured:
    """Calls of both kinds in short turns, so that whatever disturbs the machine disturbs both."""
    turn = max(seconds / TURNS, 0.01)
    figures: list[tuple[float, float]] = []
    for _ in range(TURNS):
        with_checks = _trips(_ask(checked, f"trips {turn}")).p50
        figures.append((with_checks, _trips(_ask(unchecked, f"unchecked {turn}")).p50))
    p50, without = map(statistics.median, zip(*figures, strict=True))
    return Measured(p50=p50, unchecked=without)


def _images(pair: Pair, line: Line, seconds: float, core: int) -> Measured:
    """Images take longer than calls, so they are given more time. All readers share a core: one on
    the core of the server would interrupt it while it sends."""
    client = pair.client([core])
    others = [pair.client([core]) for _ in range(line.other_readers)]
    for other in others:
        other.say(f"images {2 * seconds + 0.4}")  # begins before, ends after
    _ask(client, "images 0.2")  # warm
    answer = _ask(client, f"images {2 * seconds}")
    for other in others:
        other.line()
    _, readable, readable_p99, whole, whole_p99, sending = (1e-3 * ns for ns in answer)
    return Measured(
        readable=readable,
        readable_p99=readable_p99,
        whole=whole,
        whole_p99=whole_p99,
        sending=sending,
    )


def _share(client: Process, server: Process, late: float, seconds: float) -> Measured:
    """Processor share of a client whose replies come `late`, or of a server with an idle client."""
    if late:
        _ask(client, f"late {late} {seconds}")  # it learns how long it waits
    else:
        time.sleep(seconds)
    watched = client if late else server
    before, began = watched.ran_for(), time.monotonic()
    if late:
        _ask(client, f"late {late} {4 * seconds}")
    else:
        time.sleep(4 * seconds)
    return Measured(share=(watched.ran_for() - before) / (time.monotonic() - began))


def _ask(client: Process, question: str) -> list[float]:
    client.say(question)
    return [float(word) for word in client.line().split()]


def _trips(answer: list[float], seconds: float = 0.0) -> Measured:
    count, p50, p99 = answer
    return Measured(p50=p50 * 1e-3, p99=p99 * 1e-3, rate=count / seconds if seconds else 0.0)
