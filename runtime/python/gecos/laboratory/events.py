"""The events of a running laboratory, and their text for people."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum


class What(StrEnum):
    OUTPUT = "output"  # a program has printed a line
    READY = "ready"  # a program is ready
    ENDED = "ended"  # a program has ended by itself
    RESTARTED = "restarted"  # a program that had ended has been started again
    NOT_STARTED = "not_started"  # a program cannot be started again now
    NOT_READY = "not_ready"  # a program that was started again does not become ready
    KILLED = "killed"  # a program did not end when asked to, and was killed
    UNREAD_LISTS = "unread_lists"  # the lab file has lists now, which the programs do not read
    ALL_READY = "all_ready"  # the laboratory is ready
    CLOSING = "closing"  # all programs are being ended, the last one first


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a running laboratory. `text` describes the event for people; for OUTPUT, it is
    the line that the program printed."""

    event: What
    text: str
    program: str = ""  # "" for the whole laboratory
    # Exit status of a program that has ENDED, or the negative number of the signal that ended it.
    status: int | None = None
    restarts_in: float | None = None  # s; None if the program is not started again


Report = Callable[[Event], None]

_QUIET = (What.READY, What.RESTARTED)  # not shown, because the program itself prints a line


def show(event: Event) -> None:
    """Prints what a program of the laboratory did, in a form that people read."""
    if event.event is What.OUTPUT:
        say(f"  [{event.program}] {event.text}")
    elif event.program and event.event not in _QUIET:
        say(event.text)


def say(line: str) -> None:
    """Prints a line. The programs continue even if no program reads the output any more."""
    if sys.stdout is None:
        return
    encoding = sys.stdout.encoding or "utf-8"
    with suppress(OSError, ValueError):
        # With one write, the lines of several threads are not mixed.
        sys.stdout.write(line.encode(encoding, "backslashreplace").decode(encoding) + "\n")
        sys.stdout.flush()
