"""The end of the program, in order: leases are given back and drain, then sessions say goodbye.

So a program that ends without waiting still lifts its block, and nobody waits for its robot.
"""

from __future__ import annotations

import atexit
import contextlib
import threading
from collections.abc import Callable
from enum import IntEnum
from typing import Protocol
from weakref import WeakSet


class Turn(IntEnum):
    """Order in which objects are closed at the end of the program."""

    LEASES = 0
    SERVERS = 1
    BROKERS = 2
    LABS = 3


class Closable(Protocol):
    def close(self) -> None: ...


_waiting: dict[Turn, WeakSet[Closable]] = {turn: WeakSet() for turn in Turn}


def at_exit(closable: Closable, turn: Turn) -> None:
    """Closes it at the end of the program, unless it is gone by then. It may be closed already."""
    _waiting[turn].add(closable)


_starting = threading.RLock()  # a __del__ or a signal handler may begin a thread in the midst of it
_over = False


def begin_thread(name: str, run: Callable[..., None], *words: object) -> None:
    """Begins a daemon thread. RuntimeError when the program has ended so far that it takes none: a
    thread that is just beginning while the interpreter goes away would crash it."""
    with _starting:
        if _over:
            raise RuntimeError(f"{name}: no thread begins any more, the program ends")
        threading.Thread(target=run, args=words, name=name, daemon=True).start()


@atexit.register
def _leave() -> None:
    global _over
    for turn in Turn:
        for closable in list(_waiting[turn]):
            with contextlib.suppress(Exception):  # no caller is left to report to
                closable.close()
    with _starting:
        _over = True
