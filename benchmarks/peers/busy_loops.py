"""The busy loops beside which is measured, and what they get of their cores."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from pair import ran_for
from settings import Loops

PROGRAM = Path(__file__).resolve().parent / "busy_loop.py"


class BusyLoops:
    """One on each of `cores`; none where `loops` is nothing."""

    def __init__(self, loops: Loops | None, cores: Sequence[int]) -> None:
        self._processes: list[subprocess.Popen[str]] = []
        self._began = (0.0, 0.0)
        if loops is None:
            return
        for core in cores:
            words = [str(core), str(loops.nice), str(loops.slice_ms)]
            process = subprocess.Popen(
                [sys.executable, PROGRAM, *words], stdout=subprocess.PIPE, text=True
            )
            self._processes.append(process)
            assert process.stdout is not None
            said = process.stdout.readline().strip()
            if said != "looping":
                print(f"bench-peers: the loop on core {core}: {said}", file=sys.stderr, flush=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            process.kill()
            process.wait()
            assert process.stdout is not None
            process.stdout.close()

    def begin(self) -> None:
        self._began = (time.monotonic(), self._ran())

    def share(self) -> float:
        """The part of its core that a loop has had since begin(), on average."""
        if not self._processes:
            return 0.0
        passed = time.monotonic() - self._began[0]
        return (self._ran() - self._began[1]) / passed / len(self._processes)

    def _ran(self) -> float:
        return sum(ran_for(Path(f"/proc/{process.pid}")) for process in self._processes)
