"""Serves a Workbench whose commands with salt 0 never return, until SIGUSR1. Says which started."""

from __future__ import annotations

import signal
import threading

import gecos
from record import Record, settings
from stress.workbench import WorkbenchServant

released = False


class Workbench(WorkbenchServant):
    def __init__(self, record: Record) -> None:
        super().__init__()
        self._record = record

    def _run(self, command: int, salt: int) -> int:
        self._record.note(f"start {command}")
        print("started", command, flush=True)
        while salt == 0 and not released:
            pass
        self._record.note(f"finish {command}")
        return salt

    def tap(self, command: int, salt: int) -> int:
        return self._run(command, salt)

    def file(self, command: int, salt: int, seconds: float, run: gecos.Execution[None]) -> int:
        return self._run(command, salt)

    def gauge(self, command: int, salt: int) -> int:
        return self._run(command, salt)

    def look(self, command: int, salt: int) -> int:
        return salt

    def weigh(self, command: int, load: bytes) -> bytes:
        return load


def release(_number: int, _frame: object) -> None:
    global released
    released = True


def main() -> None:
    setting = settings()
    end = threading.Event()
    signal.signal(signal.SIGTERM, lambda _number, _frame: end.set())
    signal.signal(signal.SIGUSR1, release)
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        server.add("BENCH", Workbench(Record(setting["record"])), simulated=True)
        print("ready", flush=True)
        end.wait()


if __name__ == "__main__":
    main()
