"""Rounds: everything that stands in one table is measured in turn, in every round anew."""

from __future__ import annotations

import contextlib
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass

from pair import Broken, Pair, Process
from settings import Bar, Figure, Line, Setting


@dataclass(frozen=True, slots=True)
class Pace:
    """How much is measured."""

    rounds: int
    seconds: float  # of every line in every round
    rests: int  # calls after a second of silence, in every round


@dataclass(frozen=True, slots=True)
class Measured:
    """One line in one round: µs, or calls a second."""

    p50: float = 0.0
    p99: float = 0.0
    rate: float = 0.0

    def figure(self, of: Figure) -> float:
        return {Figure.P50: self.p50, Figure.P99: self.p99, Figure.RATE: self.rate}[of]


@dataclass(frozen=True, slots=True)
class Verdict:
    bar: Bar
    ratios: list[float]  # of the rounds; empty when there was nobody to compare with
    met: bool


Rounds = dict[str, list[Measured]]


def run(setting: Setting, there: tuple[Line, ...], pace: Pace, env: dict[str, str]) -> Rounds:
    """Measures those lines of `setting` that are there, round by round.

    A peer that breaks is left out from then on, and of what is given; ours that does ends the run.
    """
    measured: Rounds = {line.label: [] for line in there}
    cores = sorted(os.sched_getaffinity(0))
    with _busy_loops(cores[:2] if setting.busy else []):
        for number in range(1, pace.rounds + 1):
            print(f"bench-peers: {setting.title}, round {number}", file=sys.stderr, flush=True)
            for line in there:
                if line.label not in measured:
                    continue
                try:
                    measured[line.label].append(_once(setting, line, pace, cores, env))
                except Broken as why:
                    if not line.candidate.peer:
                        raise
                    print(f"bench-peers: {line.label} BROKE: {why}", file=sys.stderr, flush=True)
                    del measured[line.label]
    return measured


def _once(
    setting: Setting, line: Line, pace: Pace, cores: list[int], env: dict[str, str]
) -> Measured:
    mine, servers = cores[0], cores[0 if setting.one_core else 1]
    with contextlib.closing(Pair(line.candidate, servers, env)) as pair:
        for _ in range(line.idle_clients):
            pair.client(cores)
        client = pair.client([mine])
        _ask(client, "trips 0.1")  # warm
        if setting.outstanding:
            _ask(client, f"outstanding {setting.outstanding} {pace.seconds / 4}")
            (rate,) = _ask(client, f"outstanding {setting.outstanding} {pace.seconds}")
            return Measured(rate=rate)
        if setting.silent:
            return _trips(_ask(client, f"silent 1.0 {pace.rests}"))
        if not line.flooded:
            return _trips(_ask(client, f"trips {pace.seconds}"))
        flooder = pair.client(cores[:2])
        flooder.say(f"outstanding 64 {pace.seconds + 0.2}")  # begins before, ends after
        _ask(client, "trips 0.1")
        measured = _trips(_ask(client, f"trips {pace.seconds}"))
        flooder.line()
        return measured


def _ask(client: Process, question: str) -> list[float]:
    client.say(question)
    return [float(word) for word in client.line().split()]


def _trips(answer: list[float]) -> Measured:
    _, p50, p99 = answer
    return Measured(p50=p50 * 1e-3, p99=p99 * 1e-3)


@contextlib.contextmanager
def _busy_loops(cores: list[int]) -> Iterator[None]:
    loops = [
        subprocess.Popen(
            ["taskset", "--cpu-list", str(core), sys.executable, "-c", "while True: pass"]
        )
        for core in cores
    ]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def judge(setting: Setting, bar: Bar, measured: Rounds) -> Verdict:
    """Of every round ours beside the best of the others in it; their median counts."""
    others = [measured[label] for label in bar.others if label in measured]
    if not others:
        return Verdict(bar, [], False)
    rates = setting.figure is Figure.RATE
    best = max if rates else min
    ratios = [
        ours.figure(setting.figure) / best(other.figure(setting.figure) for other in beside)
        for ours, *beside in zip(measured[bar.ours], *others, strict=True)
    ]
    median = statistics.median(ratios)
    return Verdict(bar, ratios, median >= bar.limit if rates else median <= bar.limit)
