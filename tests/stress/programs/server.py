"""Serves a Workbench until it is ended or killed: stress_server.cpp in Python."""

from __future__ import annotations

import os
import signal
import threading
import time

import gecos
from gecos import _core, handlers
from record import Balance, Record, answer, answer_salt, settings
from stress.workbench import WorkbenchServant

of_this_thread = threading.local()
_answer = handlers._answer


def _answer_with_mark(servant: gecos.Servant, call: _core.IncomingCall, name: str) -> None:
    """On the thread of the handler: keeps when its start was marked."""
    of_this_thread.marked_ns = call.marked_ns
    _answer(servant, call, name)


class Workbench(WorkbenchServant):
    """Notes when each of its handlers begins and ends, and when its start was marked."""

    def __init__(self, record: Record) -> None:
        super().__init__()
        self._record = record

    def tap(self, command: int, salt: int) -> int:
        self._start(command, "tap")
        self._take_samples()
        return self._finish(command, "tap", answer_salt(command, salt))

    def file(self, command: int, salt: int, seconds: float, run: gecos.Execution[None]) -> int:
        self._start(command, "file")
        self._take_samples()
        if run.wait_interrupted(seconds):
            self._record.note(f"finish {command} file -")
            raise gecos.Interrupted
        return self._finish(command, "file", answer_salt(command, salt))

    def weigh(self, command: int, load: bytes) -> bytes:
        self._start(command, "weigh")
        self._finish(command, "weigh", answer(command, load))
        return load

    def gauge(self, command: int, salt: int) -> int:
        self._start(command, "gauge")
        return self._finish(command, "gauge", answer_salt(command, salt))

    def look(self, command: int, salt: int) -> int:
        self._start(command, "look")
        return self._finish(command, "look", answer_salt(command, salt))

    def _take_samples(self) -> None:
        before = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        while (sample := self.push.next()) is not None:
            self._record.note(f"take {sample.value} {before}")
            before = time.clock_gettime_ns(time.CLOCK_BOOTTIME)

    def _start(self, command: int, operation: str) -> None:
        self._record.note(f"start {command} {operation} {of_this_thread.marked_ns}")

    def _finish(self, command: int, operation: str, result: int) -> int:
        self._record.note(f"finish {command} {operation} {result}")
        return result


def serve(server: gecos.Server, medium: str, record: Record) -> None:
    handlers._answer = _answer_with_mark
    server.add("BENCH", Workbench(record), simulated=True, media=[medium])
    record.note(f"serve {os.getpid()}")


def main() -> None:
    setting = settings()
    record = Record(setting["record"])
    end = threading.Event()
    signal.signal(signal.SIGTERM, lambda _number, _frame: end.set())
    balance = Balance()
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        serve(server, setting["medium"], record)
        print("ready", flush=True)
        end.wait()
    balance.close()
    record.note("done")


if __name__ == "__main__":
    main()
