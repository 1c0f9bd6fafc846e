"""A log of a program's actions in a file that survives its kill, as in record.hpp."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import gecos
import numpy  # noqa: F401  (a writer imports it; the threads that it starts count from the beginning)


class Record:
    """Each line is one write to the end of the file, there and whole when `note` returns."""

    def __init__(self, path: str) -> None:
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o600)

    def note(self, what: str) -> None:
        os.write(self._file, f"{time.clock_gettime_ns(time.CLOCK_BOOTTIME)} {what}\n".encode())


def answer(command: int, load: bytes) -> int:
    """FNV-1a of the command's number and what came with it, as int64."""
    total = 0xCBF29CE484222325
    for byte in command.to_bytes(8, "little") + load:
        total = ((total ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    return total - (1 << 64) if total >> 63 else total


def answer_salt(command: int, salt: int) -> int:
    return answer(command, salt.to_bytes(8, "little", signed=True))


def settings() -> dict[str, str]:
    """The words of the command line, "name=value" each."""
    return dict(word.split("=", 1) for word in sys.argv[1:])


def census() -> str:
    """The open resources of this process: descriptors, threads, mapped memfds."""
    descriptors = len(list(Path("/proc/self/fd").iterdir()))
    threads = len(list(Path("/proc/self/task").iterdir()))
    memfds = Path("/proc/self/maps").read_text().count("memfd:")
    return f"{descriptors} {threads} {memfds}"


def rest_before_another_try() -> None:
    """As in another_try.hpp."""
    time.sleep(0.005)


def _census_after_a_server() -> str:
    """The first server of a process leaves it the descriptor that signals make readable."""
    tasks = Path("/proc/self/task")
    threads = len(list(tasks.iterdir()))
    with gecos.Lab() as lab, gecos.Server(lab):
        pass
    give_up = time.monotonic() + 10.0
    while len(list(tasks.iterdir())) != threads and time.monotonic() < give_up:
        time.sleep(0.001)
    return census()


class Balance:
    """Says "before …" now, and "after …" when it is told to, once as much is open as before, else
    after ten seconds: a thread that lets go of the last session ends a moment later, and /proc
    tells nobody. Balance of record.hpp."""

    def __init__(self) -> None:
        self._before = _census_after_a_server()
        print("before", self._before, flush=True)

    def close(self) -> None:
        give_up = time.monotonic() + 10.0
        while (now := census()) != self._before and time.monotonic() < give_up:
            time.sleep(0.001)
        print("after", now, flush=True)
