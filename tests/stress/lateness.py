"""How late the machine itself is: time in which no program could run counts towards no bound."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Self

STEP_S = 0.01
WORTH_NOTING_S = 0.03


def now_ns() -> int:
    """By the clock of all records."""
    return time.clock_gettime_ns(time.CLOCK_BOOTTIME)


class Watch:
    """A thread on each core that wakes every 10 ms. A virtual machine may be given one core and not
    another: no thread that may run on any core notices that."""

    def __init__(self) -> None:
        self.late: list[tuple[int, int]] = []
        """When each wake-up that was more than 30 ms late was due, and when it came, in ns."""
        self._end = threading.Event()
        self._threads = {
            core: threading.Thread(target=self._watch, name=f"lateness {core}", daemon=True)
            for core in sorted(os.sched_getaffinity(0))
        }

    def __enter__(self) -> Self:
        for core, thread in self._threads.items():
            thread.start()
            assert thread.native_id is not None
            os.sched_setaffinity(thread.native_id, {core})
        return self

    def __exit__(self, *error: object) -> None:
        self._end.set()
        for thread in self._threads.values():
            thread.join()

    def cores(self) -> list[set[int]]:
        """Where each of the threads runs."""
        return [os.sched_getaffinity(thread.native_id or 0) for thread in self._threads.values()]

    def longest_s(self) -> float:
        """The largest lateness so far, in s."""
        return max((woken - due for due, woken in self.late), default=0) * 1e-9

    def _watch(self) -> None:
        due = now_ns()
        while not self._end.wait(STEP_S):
            due, woken = due + round(STEP_S * 1e9), now_ns()
            if woken - due > WORTH_NOTING_S * 1e9:
                self.late.append((due, woken))
            due = woken


class Lateness(Watch):
    """At the end, writes a line "<due> late <woken>" to `file` for each time in which a core did
    not run its thread. If such times of two cores overlap, they are one."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self._file = file

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
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
