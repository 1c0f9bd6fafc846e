"""A client in another process closes a control loop at 1 kHz over shm: how many cycles were missed,
and by how late they began. A bare loop, which only waits, runs on the same core at the same time,
with cycles due at the same instants, so that a stall of the machine delays both by as much. With
real-time priorities the bare loop has the next higher one, so that it never waits for the closed
loop or its client. A system call that the kernel does not preempt delays both loops, and this
comparison does not show it."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "system"))  # processes.py

from processes import PATIENCE_S, Program  # noqa: E402

RATE_HZ = 1000
PROGRAM = "tests/stress/stress_loop"
TIMES_BARE, MORE = 1.5, 1
"""The promise: at most so many times the missed cycles of the bare loop, and so many more."""
PLACES = 16
"""Of a histogram of stress_loop.cpp."""


def _none() -> list[int]:
    return [0] * PLACES


@dataclass(slots=True)
class LoopCounts:
    """What one loop has seen. A place p of a histogram counts the delays below 2^p us that belong
    to no earlier place; its last one has all that are longer."""

    first_due_ns: int = 0
    last_due_ns: int = 0
    count: int = 0
    missed: int = 0
    woke: list[int] = field(default_factory=_none)
    """By how late the loop woke in a cycle."""
    answered: list[int] = field(default_factory=_none)
    """By how late, after the beginning of a cycle, the client had read its tick."""


@dataclass(slots=True)
class Loops:
    priority: str = ""
    closed: LoopCounts = field(default_factory=LoopCounts)
    bare: LoopCounts = field(default_factory=LoopCounts)

    def most_missed(self) -> float:
        return TIMES_BARE * self.bare.missed + MORE

    def keeps_its_promise(self) -> bool:
        return self.closed.missed <= self.most_missed()

    def _priority_of_bare(self) -> str:
        return "next higher" if self.priority == "real-time" else "same"

    def __str__(self) -> str:
        rows = zip(self.bare.woke, self.closed.woke, self.closed.answered, strict=True)
        counts = [[str(count) for count in row] for row in rows]
        names = [f"< {1 << place} us" for place in range(PLACES - 1)] + ["longer"]
        table = [
            f"{name:>12} {bare:>12} {closed:>14} {answered:>16}"
            for name, (bare, closed, answered) in zip(names, counts, strict=True)
            if {bare, closed, answered} != {"0"}
        ]
        return "\n".join(
            [
                f"control loop at {RATE_HZ} Hz over shm, {self.priority}: {self.closed.missed} of "
                f"{self.closed.count} cycles missed, at most {self.most_missed():g} promised; a "
                f"bare clock_nanosleep loop of the {self._priority_of_bare()} priority missed "
                f"{self.bare.missed} of {self.bare.count}",
                f"{'late by':>12} {'bare loop':>12} {'control loop':>14} {'client has tick':>16}",
                *table,
            ]
        )


def run(seconds: int, build: Path, env: Mapping[str, str]) -> Loops:
    """Lets both loops run beside each other for so long."""
    with contextlib.ExitStack() as stack:
        place = tempfile.mkdtemp(prefix="gecos-")
        stack.callback(shutil.rmtree, place, ignore_errors=True)
        inside = {**os.environ, **env, "GECOS_RUNTIME_DIR": place, "GECOS_BROKER": "shm"}
        program = ("taskset", "-c", str(max(os.sched_getaffinity(0))), build / PROGRAM)

        def start(*command: str | Path, listens: bool = False) -> Program:
            started = Program(command, inside, listens)
            stack.callback(_end, started)
            return started

        start(build / "runtime/cpp/gecos/broker/gecos-broker").wait_for("ready")
        device = start(*program, "device", listens=True)
        priority = device.wait_for("priority: ").removeprefix("priority: ")
        device.wait_for("ready")
        start(*program, "client").wait_for("ready")
        bare = start(*program, "bare", listens=True)
        bare.wait_for("ready")
        for loop in (device, bare):
            loop.tell(str(seconds * RATE_HZ))
        patience = seconds + PATIENCE_S
        return Loops(priority, closed=_counts_of(device, patience), bare=_counts_of(bare, patience))


def _counts_of(loop: Program, patience: float) -> LoopCounts:
    _, first, _, last = loop.wait_for("from ", patience).split()
    _, count, _, missed = loop.wait_for("cycles ").split()
    woke, answered = _numbers(loop.wait_for("woke ")), _numbers(loop.wait_for("answered "))
    return LoopCounts(int(first), int(last), int(count), int(missed), woke, answered)


def _numbers(line: str) -> list[int]:
    return [int(number) for number in line.split()[1:]]


def _end(program: Program) -> None:
    if program.running():
        program.kill()
    else:
        program.finish()
