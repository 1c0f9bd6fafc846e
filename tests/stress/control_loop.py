"""A control loop at 1 kHz that a client in another process closes over shm, in turns with a bare
loop that only waits: how many cycles each missed, and by how late they began. All share a core."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "system"))  # processes.py

from processes import Program  # noqa: E402

RATE_HZ = 1000
PROGRAM = "tests/stress/stress_loop"
TIMES_BARE, MORE = 1.5, 1
"""The promise: at most so many times the missed cycles of the bare loop, and so many more."""
PLACES = 16
"""Of a histogram of stress_loop.cpp."""


def _none() -> list[int]:
    return [0] * PLACES


@dataclass(slots=True)
class Turns:
    """All turns of one kind of loop. A place p of a histogram counts the delays below 2^p us that
    belong to no earlier place; its last one has all that are longer."""

    cycles: int = 0
    missed: int = 0
    woke: list[int] = field(default_factory=_none)
    """By how late the loop woke in a cycle."""
    answered: list[int] = field(default_factory=_none)
    """By how late, after the beginning of a cycle, the client had read its tick."""


@dataclass(slots=True)
class Loops:
    priority: str = ""
    closed: Turns = field(default_factory=Turns)
    bare: Turns = field(default_factory=Turns)

    def most_missed(self) -> float:
        return TIMES_BARE * self.bare.missed + MORE

    def keeps_its_promise(self) -> bool:
        return self.closed.missed <= self.most_missed()

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
                f"{self.closed.cycles} cycles missed, at most {self.most_missed():g} promised; a "
                f"bare clock_nanosleep loop missed {self.bare.missed} of {self.bare.cycles}",
                f"{'late by':>12} {'bare loop':>12} {'control loop':>14} {'client has tick':>16}",
                *table,
            ]
        )


def run(seconds: int, build: Path, env: Mapping[str, str]) -> Loops:
    """Lets both loops run so long, in turns of a second."""
    loops = Loops()
    with contextlib.ExitStack() as stack:
        place = tempfile.mkdtemp(prefix="gecos-")
        stack.callback(shutil.rmtree, place, ignore_errors=True)
        inside = {**os.environ, **env, "GECOS_RUNTIME_DIR": place, "GECOS_BROKER": "shm"}
        # On one core, so that whatever takes the core away does so from both programs at once.
        program = ("taskset", "-c", str(max(os.sched_getaffinity(0))), build / PROGRAM)

        def start(*command: str | Path, listens: bool = False) -> Program:
            started = Program(command, inside, listens)
            stack.callback(_end, started)
            return started

        start(build / "runtime/cpp/gecos/broker/gecos-broker").wait_for("ready")
        device = start(*program, "device", listens=True)
        loops.priority = device.wait_for("priority: ").removeprefix("priority: ")
        device.wait_for("ready")
        start(*program, "client").wait_for("ready")
        for turns, kind in _turns(loops, seconds):
            device.tell(f"{kind} {RATE_HZ}")
            _take(turns, device)
    return loops


def _turns(loops: Loops, seconds: int) -> Iterator[tuple[Turns, str]]:
    for _ in range(seconds):
        yield loops.closed, "closed"
        yield loops.bare, "bare"


def _take(turns: Turns, device: Program) -> None:
    _, cycles, _, missed = device.wait_for("cycles ").split()
    turns.cycles += int(cycles)
    turns.missed += int(missed)
    turns.woke = _sum(turns.woke, device.wait_for("woke "))
    turns.answered = _sum(turns.answered, device.wait_for("answered "))


def _sum(so_far: list[int], line: str) -> list[int]:
    more = [int(count) for count in line.split()[1:]]
    return [one + other for one, other in zip(so_far, more, strict=True)]


def _end(program: Program) -> None:
    if program.running():
        program.kill()
    else:
        program.finish()
