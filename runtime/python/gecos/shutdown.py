"""Ends the program in order: leases are released, then sessions are closed.

Commands for which the program did not wait still finish, and then other clients can acquire the
robot.
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
    """The order in which objects are closed at the end of the program."""

    LEASES = 0
    SERVERS = 1
    BROKERS = 2
    LABS = 3


class Closable(Protocol):
    def close(self) -> None: ...


_waiting: dict[Turn, WeakSet[Closable]] = {turn: WeakSet() for turn in Turn}


def at_exit(closable: Closable, turn: Turn) -> None:
    """Calls `closable.close()` at the end of the program. The call is made even if `closable` was
    already closed, but not if it was destroyed."""
    _waiting[turn].add(closable)


# The lock is recursive, because a __del__ or a signal handler may call begin_thread while
# begin_thread runs.
_starting = threading.RLock()
_over = False


def begin_thread(name: str, run: Callable[..., None], *words: object) -> threading.Thread:
    """Starts a daemon thread and returns it. Raises RuntimeError once the program is ending,
    because a thread that starts while the interpreter shuts down would crash the program."""
    with _starting:
        if _over:
            raise RuntimeError(f"{name}: cannot start a thread, because the program is ending")
        thread = threading.Thread(target=run, args=words, name=name, daemon=True)
        thread.start()
        return thread


@atexit.register
def _leave() -> None:
    global _over
    for turn in Turn:
        for closable in list(_waiting[turn]):
            with contextlib.suppress(Exception):  # no caller is left that could get the exception
                closable.close()
    with _starting:
        _over = True
