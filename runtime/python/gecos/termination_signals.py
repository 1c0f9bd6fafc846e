"""Waits for SIGINT or SIGTERM, so that a server can end in an orderly way."""

from __future__ import annotations

import contextlib
import signal
import socket
from types import TracebackType
from typing import Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_ENOUGH = 4096  # bytes to peek at; other signals may have arrived before SIGINT or SIGTERM


class TerminationSignals:
    """Inside the `with` block, SIGINT and SIGTERM do nothing but end `wait`. Only the main thread
    may use this class.

    Python writes each signal to a socket, whichever thread the kernel delivers the signal to. So no
    signal is lost between checking and sleeping, and no signal handler takes a lock.
    """

    def __enter__(self) -> Self:
        self._here, self._there = socket.socketpair()
        self._there.setblocking(False)
        self._handlers = {number: signal.signal(number, _nothing) for number in _SIGNALS}
        self._wakeup = signal.set_wakeup_fd(self._there.fileno(), warn_on_full_buffer=False)
        return self

    def wait(self) -> None:
        """Sleeps until SIGINT or SIGTERM arrives. Returns at once if one of them has already
        arrived."""
        while self._here.recv(1)[0] not in _SIGNALS:
            pass

    def end_wait(self) -> None:
        """Makes `wait` return without a signal. Any thread may call this method."""
        with contextlib.suppress(OSError):  # after the end of the `with` block nothing waits
            self._there.send(bytes([signal.SIGTERM]))

    def came(self) -> bool:
        """Returns whether SIGINT or SIGTERM has already arrived."""
        try:
            waiting = self._here.recv(_ENOUGH, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        except BlockingIOError:
            return False
        return any(number in _SIGNALS for number in waiting)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        signal.set_wakeup_fd(self._wakeup)
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._here.close()
        self._there.close()


def _nothing(number: int, frame: object) -> None:
    """Does nothing: the wake-up socket receives the signal."""
