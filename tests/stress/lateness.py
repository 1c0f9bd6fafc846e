"""How late the machine itself is: time in which no program could run counts towards no bound."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from types import TracebackType

STEP_S = 0.01
WORTH_NOTING_S = 0.03


def now_ns() -> int:
    """By the clock of all records."""
    return time.clock_gettime_ns(time.CLOCK_BOOTTIME)


class Watch(AbstractContextManager["Watch"]):
    """A thread on each core that wakes every 10 ms. `late` has the time at which one was due and
    that at which it woke, in ns, each time it woke more than 30 ms late. On each core, because a
    virtual machine may be given one of its cores and not the other."""

    def __init__(self) -> None:
        self.late: list[tuple[int, int]] = []
        self._end = threading.Event()
        self._threads = [
            threading.Thread(target=self._watch, args=(core,), name=f"lateness {core}", daemon=True)
            for core in sorted(os.sched_getaffinity(0))
        ]

    def __enter__(self) -> Watch:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end.set()
        for thread in self._threads:
            thread.join()

    def longest_s(self, since: int) -> float:
        """Returns by how much a thread that woke after `since` was late at most, in s."""
        return max((woken - due for due, woken in self.late if woken > since), default=0) * 1e-9

    def _watch(self, core: int) -> None:
        os.sched_setaffinity(0, {core})  # of this thread
        due = now_ns()
        while not self._end.wait(STEP_S):
            due, woken = due + round(STEP_S * 1e9), now_ns()
            if woken - due > WORTH_NOTING_S * 1e9:
                self.late.append((due, woken))
            due = woken


class Lateness(Watch):
    """Writes a line "<due> late <woken>" to `file` at the end, for each time in which a core did
    not run its thread. Such times of two cores that meet are one."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self._file = file

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        super().__exit__(kind, error, trace)
        with self._file.open("a") as notes:
            notes.writelines(f"{due} late {woken}\n" for due, woken in joined(self.late))


def joined(spans: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """The same time in spans that do not meet, in their order."""
    apart: list[tuple[int, int]] = []
    for begin, end in sorted(spans):
        if apart and begin <= apart[-1][1]:
            apart[-1] = (apart[-1][0], max(apart[-1][1], end))
        else:
            apart.append((begin, end))
    return apart
