"""Orderly end of the program: leases are released and drain, then sessions are closed.

So the commands of a program that ends without waiting still finish, and its robot is free after.
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
    """Closes `closable` at the end of the program if it still exists; also if already closed."""
    _waiting[turn].add(closable)


_starting = threading.RLock()  # a __del__ or signal handler may interrupt begin_thread and call it
_over = False


def begin_thread(name: str, run: Callable[..., None], *words: object) -> None:
    """Starts a daemon thread. Raises RuntimeError once the program is ending: a thread that starts
    while the interpreter shuts down would crash it."""
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
