"""The thread of a server that measures and publishes while handlers run on other threads."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

Publish = Callable[[threading.Event], object]
"""Publishes until the event is set."""


class Publisher:
    """Runs a function that publishes. The end of the `with` block sets the event that the function
    got, waits for its return, and raises the exception that ended it early."""

    def __init__(self) -> None:
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        self._error: BaseException | None = None

    def start(self, publish: Publish, failed: Callable[[], None]) -> None:
        """Calls `failed` on the thread of `publish` when `publish` raises an exception."""
        self._thread = threading.Thread(
            target=self._run, args=(publish, failed), name="gecos-publish", daemon=True
        )
        self._thread.start()

    def _run(self, publish: Publish, failed: Callable[[], None]) -> None:
        try:
            publish(self._ended)
        except BaseException as error:
            self._error = error
            failed()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        if self._error is not None and error is None:
            raise self._error
