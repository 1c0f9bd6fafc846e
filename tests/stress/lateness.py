"""How late the machine itself is: time in which no program could run counts towards no bound."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from types import TracebackType

STEP_S = 0.01
WORTH_NOTING_S = 0.03


def now_ns() -> int:
    """By the clock of all records."""
    return time.clock_gettime_ns(time.CLOCK_BOOTTIME)


class Lateness:
    """Wakes every 10 ms, and writes a line "<due> late <woken>", in ns, each time it woke more than
    30 ms late."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="lateness")

    def __enter__(self) -> Lateness:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end.set()
        self._thread.join()

    def _watch(self) -> None:
        with self._file.open("a") as notes:
            due = now_ns()
            while not self._end.wait(STEP_S):
                due, woken = due + round(STEP_S * 1e9), now_ns()
                if woken - due > WORTH_NOTING_S * 1e9:
                    notes.write(f"{due} late {woken}\n")
                due = woken
