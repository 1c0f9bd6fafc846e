"""Being told of a command's end: callbacks run one by one on a Python thread of their own."""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import threading
import traceback
from collections.abc import Callable
from typing import NamedTuple, Protocol

from gecos import log


class Ending(Protocol):
    """What becomes readable when it is over."""

    def fileno(self) -> int: ...


class _Awaited(NamedTuple):
    ending: Ending  # keeps the descriptor
    descriptor: int  # a copy: several may wait for one command
    callback: Callable[[], object]


class _Watch:
    """A thread that sleeps on all descriptors at once. It ends with the program."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._new: list[_Awaited] = []
        self._here, self._there = socket.socketpair()
        self._there.setblocking(False)  # this thread itself may add more than it has read of
        thread = threading.Thread(target=self._run, name="gecos-callbacks", daemon=True)
        thread.start()

    def add(self, ending: Ending, callback: Callable[[], object]) -> None:
        with self._lock:
            self._new.append(_Awaited(ending, os.dup(ending.fileno()), callback))
        with contextlib.suppress(BlockingIOError):  # it has been told often enough
            self._there.send(b"!")

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
        with self._lock:
            new, self._new = self._new, []
        for awaited in new:
            selector.register(awaited.descriptor, selectors.EVENT_READ, awaited)


def call(callback: Callable[[], object]) -> None:
    """A callback has no caller that could be told. Nor does sys.exit() in one end more than it:
    the thread goes on with the callbacks of others."""
    try:
        callback()
    except BaseException:
        log.error("command", f"a callback of a command failed\n{traceback.format_exc()}")


_watch: _Watch | None = None
_starting = threading.Lock()


def when_ended(ending: Ending, callback: Callable[[], object]) -> None:
    """Calls it once `ending` is readable."""
    global _watch
    with _starting:
        if _watch is None:
            _watch = _Watch()
        _watch.add(ending, callback)


def _forget() -> None:
    """A forked child has no such thread, and none of its commands either."""
    global _watch, _starting
    _watch, _starting = None, threading.Lock()


os.register_at_fork(after_in_child=_forget)
