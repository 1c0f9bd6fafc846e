"""Callbacks at the end of a command: they run one by one on a Python thread of their own."""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import threading
import traceback
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from gecos import log
from gecos.shutdown import begin_thread


class Ending(Protocol):
    """The owner of a descriptor that becomes readable when the command is terminal."""

    def fileno(self) -> int: ...


class _Awaited(NamedTuple):
    ending: Ending  # keeps the descriptor
    descriptor: int  # a duplicate: several callbacks may wait for one command
    callback: Callable[[], object]


class _Watch:
    """A thread that sleeps on all descriptors at once. It ends with the program.

    A signal handler or a `__del__` may call `add` while `add` is running on the same thread. So
    `add` must not wait for a lock: the interrupted call would never release it.
    """

    def __init__(self) -> None:
        self._new: deque[_Awaited] = deque()
        self._here, self._there = socket.socketpair()
        self._there.setblocking(False)  # a callback on the reading thread may fill the socket
        self._runs = False
        self._taken = threading.Lock()  # held by the one thread that runs callbacks

    def add(self, ending: Ending, callback: Callable[[], object]) -> None:
        self._new.append(_Awaited(ending, os.dup(ending.fileno()), callback))
        with contextlib.suppress(BlockingIOError):  # the thread has wake-ups pending
            self._there.send(b"!")
        if not self._runs:
            begin_thread("gecos-callbacks", self._begin)

    def _begin(self) -> None:
        """Runs the callbacks, unless another thread started at the same time already does."""
        self._runs = True
        if self._taken.acquire(blocking=False):
            self._run()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._here, selectors.EVENT_READ)
            while True:
                for key, _ in selector.select():
                    awaited: _Awaited | None = key.data
                    if awaited is None:
                        self._welcome(selector)
                        continue
                    selector.unregister(awaited.descriptor)
                    os.close(awaited.descriptor)
                    call(awaited.callback)

    def _welcome(self, selector: selectors.BaseSelector) -> None:
        self._here.recv(4096)
        while self._new:
            awaited = self._new.popleft()
            selector.register(awaited.descriptor, selectors.EVENT_READ, awaited)

    def close(self) -> None:
        """Closes an instance that was never used."""
        self._here.close()
        self._there.close()


def call(callback: Callable[[], object]) -> None:
    """Runs a callback and logs its exception. sys.exit() in a callback ends only this callback:
    the thread continues with the next one."""
    try:
        callback()
    except BaseException:
        log.error("command", f"a callback of a command failed\n{traceback.format_exc()}")


_watches: dict[str, _Watch] = {}  # at most one entry, made at first use


def when_ended(ending: Ending, callback: Callable[[], object]) -> None:
    """Calls `callback` once `ending` is readable. Also for signal handlers and `__del__`."""
    _watch().add(ending, callback)


def _watch() -> _Watch:
    known = _watches.get("")
    if known is None:
        new = _Watch()
        known = _watches.setdefault("", new)
        if known is not new:  # another thread was faster
            new.close()
    return known


# A forked child has neither the callback thread nor the parent's commands.
os.register_at_fork(after_in_child=_watches.clear)
