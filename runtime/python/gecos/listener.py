"""Gives the samples of a stream to a function, on a dedicated thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Generic, Self, TypeVar

from gecos import log
from gecos.errors import StreamLost
from gecos.shutdown import begin_thread

if TYPE_CHECKING:
    from gecos.stream import Sample, Stream

A = TypeVar("A")
T = TypeVar("T")


class Listener(Generic[T]):
    """Calls a function for each sample of a stream, in order, until the Listener or the stream is
    closed, or until the stream ends. `stream.listen` makes a Listener.

    The functions run on a thread that only this Listener uses, so they may block, issue commands
    and wait for them, and close their Lab. A slow function misses old samples, and `Sample.lost`
    says how many; it delays neither the server nor another reader. The thread keeps the Listener
    alive: if the program drops it without `close()`, it goes on.
    """

    def __init__(
        self,
        stream: Stream[T],
        callback: Callable[[Sample[T]], object],
        ended: Callable[[StreamLost], object] | None,
    ) -> None:
        self._stream = stream
        self._callback = callback
        self._ended = ended
        self._thread = begin_thread("gecos-listener", self._run)

    def close(self) -> None:
        """Ends the subscription. Waits for no sample, but until a function that is running has
        returned; afterwards the functions are not called again. If one of the functions calls
        `close()`, it is the last call. Any thread may call `close()`. The end of a `with` block of
        the Listener does the same."""
        self._stream.close()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _run(self) -> None:
        try:
            for sample in self._stream:
                self._call("callback", self._callback, sample)
        except StreamLost as lost:
            self._end(lost)

    def _end(self, lost: StreamLost) -> None:
        if self._ended is not None:
            self._call("callback for the end", self._ended, lost)
        elif self._stream._core.loss_text():  # empty if the program closed the Lab
            log.error("client", f"the callback gets no more samples: {lost}")

    def _call(self, what: str, function: Callable[[A], object], argument: A) -> None:
        """Calls a function of the program and logs its exception. sys.exit() ends only this call;
        the thread continues with the next sample."""
        try:
            function(argument)
        except BaseException:
            import traceback

            name = self._stream._name
            log.error("client", f"the {what} of stream {name} failed\n{traceback.format_exc()}")
