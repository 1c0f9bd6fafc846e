"""A subscription to an outward stream: the newest sample, or one after the other."""

from __future__ import annotations

import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from gecos.errors import StreamLost
from gecos.wire import DecodeError, Decoder

if TYPE_CHECKING:
    from gecos import _core

T = TypeVar("T")
_MOMENT = 0.01  # s


@dataclass(frozen=True, slots=True)
class Sample(Generic[T]):
    """One value of a stream."""

    value: T
    sequence: int  # rises by one per published sample
    lost: int  # samples between the last one read and this one that were not read
    stamp: float  # when it was measured, Unix time in s by the server's clock
    age: float  # s, at reading; on one host exact, between hosts as good as their clocks


class Stream(Generic[T]):
    """Samples as they come, from the newest there is at first. A slow reader loses old ones and is
    told how many. A sample that does not decode is passed over: it counts as lost (once one was
    read), and as `unreadable`.

    Iterating waits for each next sample and ends with `close()`. A server that is gone or silent,
    or closed the session, raises StreamLost, and so does a Lab that is closed. One thread or task
    reads at a time: others wait for it in `next`, within their timeout, and `latest` refuses.
    """

    def __init__(self, core: _core.Stream, decode: Callable[[Decoder], T], name: str) -> None:
        self._core = core
        self._decode = decode
        self._name = name
        self._reading = threading.Lock()
        self._waiting = False  # who reads does so until a sample comes
        self._read = 0
        self._last_unreadable = 0
        self._unreadable = 0

    def latest(self) -> Sample[T] | None:
        """The newest sample, again if need be; None before the first, while the newest does not
        decode, and after `close()`. Never waits for a sample.

        Raises StreamLost when the server is gone or silent, or the Lab was closed. A silent one is
        noticed only when its silence has lasted 1.3 s: until then look at `age`. Raises
        RuntimeError while another thread or task waits in `next` of the same stream.
        """
        while self._waiting or not self._reading.acquire(timeout=_MOMENT):
            if self._waiting:
                raise RuntimeError(
                    f"stream {self._name}: another thread or task waits for its next sample, and "
                    "this would wait with it; open a stream for each of them"
                )
        try:
            raw = self._core.latest()
            if isinstance(raw, str):
                raise self._lost()
            return None if raw is None else self._sample(*raw)
        finally:
            self._reading.release()

    def next(self, timeout: float | None = None) -> Sample[T]:
        """The next unread sample; it is old when you read more slowly than the server publishes.
        For what is true now, ask `latest()`.

        Raises TimeoutError after `timeout` seconds without one, EOFError when the stream was
        closed, StreamLost when the server is gone or the Lab was closed.
        """
        sample = self._next(timeout)
        if sample is None:
            raise EOFError(f"stream {self._name} was closed")
        return sample

    @property
    def unreadable(self) -> int:
        """How many samples came that do not decode. Their server is broken: one that means another
        type is refused when the stream is opened."""
        return self._unreadable

    def __iter__(self) -> Iterator[Sample[T]]:
        while (sample := self._next(None)) is not None:
            yield sample

    async def __aiter__(self) -> AsyncIterator[Sample[T]]:
        import asyncio

        while True:
            try:
                sample = await asyncio.to_thread(self._next, 0.1)
            except TimeoutError:
                continue
            if sample is None:
                return
            yield sample

    def close(self) -> None:
        """Ends the subscription; a reader that waits gets EOFError."""
        self._core.close()

    def _next(self, timeout: float | None) -> Sample[T] | None:
        end = None if timeout is None else time.monotonic() + timeout
        patience = -1 if timeout is None else min(max(0.0, timeout), threading.TIMEOUT_MAX)
        if not self._reading.acquire(timeout=patience):
            raise TimeoutError(
                f"stream {self._name}: no sample within {timeout} s, for which another thread waits"
            )
        try:
            self._waiting = True
            left = None if end is None else max(0.0, end - time.monotonic())
            while True:
                raw = self._core.next(left)
                if raw == "closed":
                    return None
                if raw == "lost":
                    raise self._lost()
                if raw == "nothing":
                    break
                if (sample := self._sample(*raw)) is not None:
                    return sample
                if end is not None and (left := end - time.monotonic()) <= 0:
                    break
        finally:
            self._waiting = False
            self._reading.release()
        raise TimeoutError(f"stream {self._name}: no sample within {timeout} s")

    def _lost(self) -> StreamLost:
        return StreamLost(
            f"stream {self._name}: its server is gone, silent or has closed the session, or its "
            "Lab is closed; create a new proxy and open the stream again"
        )

    def _sample(self, raw: bytes, sequence: int, stamp_ns: int, now_ns: int) -> Sample[T] | None:
        try:
            value = self._decode(Decoder(raw))
        except DecodeError:
            self._unreadable += sequence != self._last_unreadable
            self._last_unreadable = sequence
            return None
        lost = sequence - self._read - 1 if 0 < self._read < sequence else 0
        self._read = sequence
        return Sample(
            value=value,
            sequence=sequence,
            lost=lost,
            stamp=stamp_ns * 1e-9,
            age=(now_ns - stamp_ns) * 1e-9,
        )
