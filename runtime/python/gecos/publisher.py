"""The thread of a server that measures and publishes while the handlers run on other threads."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

Publish = Callable[[threading.Event], object]
"""A function that publishes samples until its argument, a `threading.Event`, is set."""


class Publisher:
    """Runs a function in a thread of its own; the function publishes samples. The end of the `with`
    block sets the event that was given to the function, and waits until the function returns. If
    the function raised an exception, the end of the block raises this exception again."""

    def __init__(self) -> None:
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        self._error: BaseException | None = None

    def start(self, publish: Publish, failed: Callable[[], None]) -> None:
        """Starts the thread of `publish`. If `publish` raises an exception, the thread calls
        `failed`."""
        thread = threading.Thread(
            target=self._run, args=(publish, failed), name="gecos-publish", daemon=True
        )
        thread.start()
        self._thread = thread

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
