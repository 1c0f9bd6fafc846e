"""Implements `async for` over a stream: a dedicated thread waits for each sample."""

from __future__ import annotations

import asyncio
import contextlib
import weakref
from collections import deque
from collections.abc import AsyncIterator
from queue import SimpleQueue
from typing import TYPE_CHECKING, Generic, TypeVar

from gecos.shutdown import begin_thread

if TYPE_CHECKING:
    from gecos.stream import Sample, Stream

T = TypeVar("T")
_LONGEST = 0.1  # s until the thread notices that the task has stopped waiting


class Turn(Generic[T]):
    """One request of a task for the next sample."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.over = False  # True when the task has stopped waiting
        self.taken: deque[Sample[T]] = deque()  # at most one sample; the code that pops it owns it
        self._loop = loop
        self._ended = loop.create_future()
        self._error: BaseException | None = None

    async def wait(self) -> Sample[T]:
        await self._ended
        if self._error is not None:
            raise self._error
        if not self.taken:
            raise StopAsyncIteration
        return self.taken.pop()

    def serve(self, stream: Stream[T]) -> None:
        """Waits for the next sample of `stream`. Runs on the reader's thread."""
        while not self.over:
            try:
                stream._next(_LONGEST, self)
            except TimeoutError:
                continue
            except BaseException as error:
                self._error = error
            break
        with contextlib.suppress(RuntimeError):  # the event loop may be closed
            self._loop.call_soon_threadsafe(_set, self._ended)


def _set(future: asyncio.Future[None]) -> None:
    if not future.done():
        future.set_result(None)


class SampleReader(AsyncIterator["Sample[T]"]):
    """Awaits samples on a dedicated thread. The thread waits only while a task awaits a sample, so
    it never reads ahead. The thread ends when the SampleReader is destroyed.

    The thread pool of the event loop is not used, because each stream would occupy one of its few
    threads.
    """

    def __init__(self, stream: Stream[T]) -> None:
        self._stream = stream
        self._asked: SimpleQueue[Turn[T] | weakref.ref[SampleReader[T]]] = SimpleQueue()
        self._begun = False

    async def __anext__(self) -> Sample[T]:
        if not self._begun:
            end = weakref.ref(self, self._asked.put)
            begin_thread("gecos-reader", _serve, self._stream, self._asked, end)
            self._begun = True
        turn: Turn[T] = Turn(asyncio.get_running_loop())
        self._asked.put(turn)
        try:
            return await turn.wait()
        finally:
            turn.over = True
            self._stream._take_back(turn)


def _serve(
    stream: Stream[T],
    asked: SimpleQueue[Turn[T] | weakref.ref[SampleReader[T]]],
    end: weakref.ref[SampleReader[T]],
) -> None:
    """Runs the reader's thread. The argument `end` is a weak reference that this function only
    keeps alive, because a destroyed weak reference does not call its callback."""
    while isinstance(turn := asked.get(), Turn):
        turn.serve(stream)
        del turn  # a Turn would keep its event loop alive
