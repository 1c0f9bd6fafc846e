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
    print("ready ", flush=True)
    for line in sys.stdin:
        words = line.split()
        match words:
            case ["trips", seconds]:
                said = _summed_up(_trips(call, float(seconds)))
            case ["silent", seconds, count]:
                said = _summed_up(_silent(call, float(seconds), int(count)))
            case _:
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


def _of_the_clock() -> int:
    """What is between two looks at the clock when nothing else is, in ns."""
    times: list[int] = []
    before = time.perf_counter_ns()
    while len(times) < 10_000:
        after = time.perf_counter_ns()
        times.append(after - before)
        before = after
    return _quantile(times, 0.5)


def _quantile(times: list[int], part: float) -> int:
    return sorted(times)[int((len(times) - 1) * part)]


def _summed_up(times: list[int]) -> str:
    clock = _of_the_clock()
    return f"{len(times)} {_quantile(times, 0.5) - clock} {_quantile(times, 0.99) - clock}"
