"""Runs the callbacks that programs add to commands, one by one on a dedicated thread."""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from gecos import log
from gecos.shutdown import begin_thread


class Ending(Protocol):
    """Owns a descriptor that becomes readable when a command is terminal."""

    def fileno(self) -> int: ...


class _Awaited(NamedTuple):
    ending: Ending  # kept alive: it owns the original descriptor
    descriptor: int  # a duplicate, because several callbacks may wait for one command
    callback: Callable[[], object]


class _Watch:
    """A daemon thread that waits for the descriptors of all commands with callbacks.

    A signal handler or a `__del__` may call `add` while `add` is running on the same thread.
    Therefore `add` must not wait for a lock, because the interrupted call could not release the
    lock.
    """

    def __init__(self) -> None:
        """Raises OSError if the process is out of descriptors. The thread itself needs no more."""
        self._new: deque[_Awaited] = deque()
        self._selector = selectors.DefaultSelector()
        try:
            self._here, self._there = socket.socketpair()
        except OSError:
            self._selector.close()
            raise
        self._selector.register(self._here, selectors.EVENT_READ)
        self._there.setblocking(False)  # so that no callback blocks in `send`
        self._runs = False
        self._taken = threading.Lock()  # held by the one thread that runs callbacks

    def add(self, ending: Ending, callback: Callable[[], object]) -> None:
        self._new.append(_Awaited(ending, os.dup(ending.fileno()), callback))
        # If the socket is full, the thread has bytes to read and wakes up without this byte.
        with contextlib.suppress(BlockingIOError):
            self._there.send(b"!")
        if not self._runs:
            begin_thread("gecos-callbacks", self._begin)

    def _begin(self) -> None:
        """Runs the callbacks, unless another thread that was started at the same time runs them."""
        self._runs = True
        if self._taken.acquire(blocking=False):
            self._run()

    def _run(self) -> None:
        while True:
            for key, _ in self._selector.select():
                awaited: _Awaited | None = key.data
                if awaited is None:
                    self._welcome()
                    continue
                self._selector.unregister(awaited.descriptor)
                os.close(awaited.descriptor)
                call(awaited.callback)

    def _welcome(self) -> None:
        self._here.recv(4096)
        while self._new:
            awaited = self._new.popleft()
            self._selector.register(awaited.descriptor, selectors.EVENT_READ, awaited)

    def close(self) -> None:
        """Closes the descriptors of a watch that was never used."""
        self._selector.close()
        self._here.close()
        self._there.close()


def call(callback: Callable[[], object]) -> None:
    """Runs a callback and logs its exception. sys.exit() in a callback ends only this callback; the
    thread continues with the next one."""
    try:
        callback()
    except BaseException:
        import traceback

        log.error("command", f"a callback of a command failed\n{traceback.format_exc()}")


_watches: dict[str, _Watch] = {}  # at most one watch, created at first use


def when_ended(ending: Ending, callback: Callable[[], object]) -> None:
    """Calls `callback` once the descriptor of `ending` is readable. Signal handlers and `__del__`
    may call `when_ended`."""
    _watch().add(ending, callback)


def _watch() -> _Watch:
    known = _watches.get("")
    if known is None:
        new = _Watch()
        known = _watches.setdefault("", new)
        if known is not new:  # another thread has created the watch in the meantime
            new.close()
    return known


# A forked child has neither the callback thread nor the parent's commands.
os.register_at_fork(after_in_child=_watches.clear)
