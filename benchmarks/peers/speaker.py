"""What every program of `make bench-peers` says, for clients in Python; the words are in
speaker.hpp."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

Call = Callable[[float], float]
"""Sends a call with this stamp and waits; the answer's stamp."""


def speak(call: Call) -> None:
    """Answers every line of standard input with a line, until there is no more."""

    def answer(words: list[str]) -> str | None:
        match words:
            case ["trips", seconds]:
                return _summed_up(_trips(call, float(seconds)))
            case ["silent", seconds, count]:
                return _summed_up(_silent(call, float(seconds), int(count)))
        return None

    answer_each(answer)


def answer_each(answer: Callable[[list[str]], str | None]) -> None:
    """Answers every line by what `answer` says to its words; it knows nothing of some words."""
    print("ready ", flush=True)
    for line in sys.stdin:
        said = answer(line.split())
        if said is None:
            sys.exit(f"asked for {line!r}, which clients in Python are not")
        print(said, flush=True)


def _trips(call: Call, seconds: float) -> list[int]:
    times: list[int] = []
    stamp = 0.0
    before = time.perf_counter_ns()
    end = before + int(seconds * 1e9)
    while before < end:
        stamp += 1.0
        if call(stamp) != stamp:
            sys.exit("the answer belongs to another call")
        after = time.perf_counter_ns()
        times.append(after - before)
        before = after
    return times


def _silent(call: Call, seconds: float, count: int) -> list[int]:
    times: list[int] = []
    for stamp in map(float, range(count)):
        time.sleep(seconds)
        before = time.perf_counter_ns()
        if call(stamp) != stamp:
            sys.exit("the answer belongs to another call")
        times.append(time.perf_counter_ns() - before)
    return times


def of_the_clock() -> int:
    """What is between two looks at the clock when nothing else is, in ns."""
    times: list[int] = []
    before = time.perf_counter_ns()
    while len(times) < 10_000:
        after = time.perf_counter_ns()
        times.append(after - before)
        before = after
    return quantile(times, 0.5)


def quantile(times: list[int], part: float) -> int:
    return sorted(times)[int((len(times) - 1) * part)]


def _summed_up(times: list[int]) -> str:
    clock = of_the_clock()
    return f"{len(times)} {quantile(times, 0.5) - clock} {quantile(times, 0.99) - clock}"
