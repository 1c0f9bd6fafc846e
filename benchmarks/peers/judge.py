"""What a line of a table measures in each round, and whether that meets a bar."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass

from settings import Bar, Figure


@dataclass(frozen=True, slots=True)
class Measured:
    """One line in one round: µs, calls a second, parts of a core."""

    p50: float = 0.0
    p99: float = 0.0
    rate: float = 0.0
    loops: float = 0.0
    share: float = 0.0
    unchecked: float = 0.0  # p50 of the calls that nothing checks
    readable: float = 0.0  # p50 of what images take; images.hpp says from when until when
    readable_p99: float = 0.0
    whole: float = 0.0
    whole_p99: float = 0.0
    sending: float = 0.0

    def figure(self, of: Figure) -> float:
        return {
            Figure.P50: self.p50,
            Figure.P99: self.p99,
            Figure.RATE: self.rate,
            Figure.LOOPS: self.loops,
            Figure.SHARE: 100 * self.share,
            Figure.CHECKS: _quotient(self.p50, self.unchecked),
            Figure.READABLE: self.readable,
            Figure.READABLE_P99: self.readable_p99,
            Figure.WHOLE: self.whole,
            Figure.WHOLE_P99: self.whole_p99,
            Figure.SENDING: self.sending,
        }[of]


@dataclass(frozen=True, slots=True)
class Verdict:
    bar: Bar
    ratios: list[float]  # one for each round; empty without another candidate
    met: bool


Rounds = dict[str, list[Measured]]


def judge(bar: Bar, measured: Rounds) -> Verdict:
    """For each round, our figure divided by the best of the others in that round."""
    others = [measured[label] for label in bar.others if label in measured]
    if bar.others and not others:
        return Verdict(bar, [], False)
    best = max if bar.figure.more_is_better else min
    ratios = [
        _quotient(
            ours.figure(bar.figure),
            best(other.figure(bar.figure) for other in beside) if beside else 1.0,
        )
        for ours, *beside in zip(measured[bar.ours], *others, strict=True)
    ]
    if not bar.rounds:
        return Verdict(bar, ratios, _holds(bar, statistics.median(ratios)))
    held = sum(_holds(bar, ratio) for ratio in ratios)
    return Verdict(bar, ratios, held >= bar.rounds * len(ratios))


def _quotient(ours: float, other: float) -> float:
    """Beside a peer that leaves nothing to the loops whatever is left is infinitely more."""
    if other:
        return ours / other
    return math.inf if ours else 1.0


def _holds(bar: Bar, ratio: float) -> bool:
    return ratio >= bar.limit if bar.figure.more_is_better else ratio <= bar.limit
