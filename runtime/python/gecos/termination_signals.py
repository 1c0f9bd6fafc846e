"""SIGINT and SIGTERM end a server in order."""

from __future__ import annotations

import signal
import socket
from types import TracebackType
from typing import Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_ENOUGH = 4096  # other signals that came before it


class TerminationSignals:
    """Inside the block these signals only end `wait`. For the main thread.

    Whichever thread the kernel gives the signal to, it arrives on a socket: none is lost between
    looking and sleeping, and no lock is taken in a handler.
    """

    def __enter__(self) -> Self:
        self._here, self._there = socket.socketpair()
        self._there.setblocking(False)
        self._handlers = {number: signal.signal(number, _nothing) for number in _SIGNALS}
        self._wakeup = signal.set_wakeup_fd(self._there.fileno(), warn_on_full_buffer=False)
        return self

    def wait(self) -> None:
        """Sleeps until the first of these signals; returns at once when one arrived before."""
        while self._here.recv(1)[0] not in _SIGNALS:
            pass

    def came(self) -> bool:
        """Whether one of them came already."""
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
    """The socket has it."""
