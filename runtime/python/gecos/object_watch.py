"""Watching which objects come online, fall silent and go."""

from __future__ import annotations

from collections.abc import Iterator
from types import TracebackType
from typing import TYPE_CHECKING, Self

from gecos.wire import from_bytes

if TYPE_CHECKING:
    from gecos_idl.broker_types import Registration

    from gecos import _core


class ObjectWatch:
    """Reports each change of the broker's list once. After a restart of the broker, reports only
    real changes. `lab.watch()` makes an ObjectWatch.

    Iterating waits for each change, and ends after `close()` or when the Lab is closed. The first
    changes are the objects that are already online or silent. While no broker answers, there are no
    changes, because the objects continue to run. Only one thread reads at a time.
    """

    def __init__(self, core: _core.ObjectWatch) -> None:
        self._core = core

    def next(self, timeout: float | None = None) -> Registration:
        """Returns the next change. Raises TimeoutError after `timeout` seconds without a change,
        and EOFError if the watch or its Lab was closed."""
        from gecos_idl.broker_types import Registration

        change = self._core.next(timeout)
        if isinstance(change, bytes):
            return from_bytes(Registration, change)
        if change:
            raise TimeoutError(f"no object came, fell silent or went within {timeout:g} s")
        raise EOFError("the watch of the broker's list, or its Lab, was closed")

    @property
    def skipped(self) -> int:
        """The number of changes that this watch did not report. The watch misses changes if it is
        read too late, because the broker keeps only the last 1024 changes. It then reports only the
        state after the missed changes."""
        return self._core.skipped()

    def close(self) -> None:
        self._core.close()

    def __iter__(self) -> Iterator[Registration]:
        while True:
            try:
                yield self.next()
            except EOFError:
                return

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
