"""Streams for programs that run longer than the servers that they use."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Generic, Self, TypeVar, Unpack

from gecos.errors import DeadlineMissed, StreamLost, may_pass
from gecos.lab import CreateOptions, Lab
from gecos.proxy import Object
from gecos.reconnecting import FAILURES, Source
from gecos.stream import Sample, Stream

P = TypeVar("P", bound=Object)
T = TypeVar("T")
_SLICE = 1.0  # s; a `next` that waits for an object looks this often whether it was closed


class ReconnectingStream(Generic[P, T]):
    """A stream that is opened again, through a new proxy, when it is lost or silent.

        with gecos.ReconnectingStream(
            lab, Manipulator, "RX90", lambda robot: robot.tool.stream()
        ) as tool:
            for sample in tool:
                print(sample.value)

    The function `open` opens the stream. `silence` is the time in s without a new sample after
    which a stream is opened again; it must exceed the period of the stream. Silence between two
    events is no loss. The other parameters are those of Reconnecting.

    Samples that are published while the stream is not open are not read, and their number is not
    known: `Sample.lost` counts only since the stream was opened last, and `reopened` says how
    often it was opened again.

    Only one thread may call `tick` and `next`. Any thread may call `latest`, but while the other
    thread waits in `next`, `latest` raises RuntimeError as that of a Stream. Any thread may call
    `close`.
    """

    def __init__(
        self,
        lab: Lab,
        interface: type[P],
        name: str,
        open: Callable[[P], Stream[T]],
        *,
        between_tries: float = 0.5,
        silence: float = 1.0,
        **create: Unpack[CreateOptions],
    ) -> None:
        self._source = Source(lab, interface, name, create)
        self._open = open
        self._between_tries = between_tries
        self._silence = silence
        self._closed = threading.Event()
        # The sequence number and the time stamp of the sample that `next` returned last.
        self._read: tuple[int, float] | None = None
        self._lock = threading.Lock()  # never held while connecting; guards the members below
        self._stream: Stream[T] | None = None
        self._proxy: P | None = None
        self._problem = f"'{name}' sent no sample yet"
        self._times_opened = 0
        self._next_try = 0.0
        # The time at which the last attempt to open the stream ended, or at which `next` returned
        # a sample.
        self._heard = 0.0

    @property
    def name(self) -> str:
        return self._source.name

    @property
    def proxy(self) -> P | None:
        """The proxy through which the stream was opened; None while there is no stream."""
        with self._lock:
            return self._proxy

    @property
    def reopened(self) -> int:
        """The number of times that the stream was opened again. Each time, an unknown number of
        samples may have been lost."""
        with self._lock:
            return max(0, self._times_opened - 1)

    def tick(self) -> None:
        """Opens the stream when it is not open, is lost or is silent. Call this method
        periodically. It returns at once while samples arrive. Otherwise it opens the stream, which
        takes at most `patience` plus one second. `latest` says why this failed."""
        with self._lock:
            if self._closed.is_set() or time.monotonic() < self._next_try or self._alive():
                return
        self._lose()
        with contextlib.suppress(*FAILURES):
            self._connect(0.0)

    def latest(self) -> Sample[T]:
        """Returns the newest sample, even if it was read before. Never waits. Raises StreamLost,
        which says the reason, if there is no sample or if the newest one is older than
        `silence`."""
        silent = f"'{self.name}' no longer sends samples"
        with self._lock:
            if self._stream is None:
                raise StreamLost(self._problem)
            try:
                sample = self._stream.latest()
            except StreamLost as lost:
                raise StreamLost(silent) from lost
        if sample is None:
            raise StreamLost(f"'{self.name}' sent no sample yet")
        if sample.age > self._silence:
            raise StreamLost(silent)
        return sample

    def next(self, timeout: float | None = None) -> Sample[T]:
        """Returns the next unread sample. Opens the stream as `tick` does, and waits for an object
        that is not online. Opening the stream may exceed `timeout` by `patience` plus one second.

        Raises TimeoutError after `timeout` seconds without a sample; if the stream is not open, the
        text says why. Raises DeadlineMissed as the `next` of a Stream, and EOFError if this stream
        or its Lab was closed. Raises CreateError, CommandFailed or ConnectionFailed if the object
        is online but cannot be used, for example because of its type. A later call tries again.
        """
        end = math.inf if timeout is None else time.monotonic() + timeout
        while not (self._closed.is_set() or self._source.lab._closed):
            if self._stream is None:
                self._try_to_open(end)
            stream = self._stream  # read once, because another thread may call `close`
            sample = None if stream is None else self._next_of(stream, end)
            if sample is not None:
                return sample
            if time.monotonic() >= end:
                why = f"; {self._problem}" if self._stream is None else ""
                raise TimeoutError(f"{self.name}: no sample within {timeout} s{why}")
        raise EOFError(f"the stream of {self.name}, or its Lab, was closed")

    def close(self) -> None:
        """Ends the subscription. A `next` that waits for a sample raises EOFError at once. If it
        waits for the object to be found again, it raises EOFError within about one second.
        `latest` raises StreamLost, and `tick` does nothing."""
        self._closed.set()
        self._lose(f"the stream of '{self.name}' is closed")

    def __iter__(self) -> Iterator[Sample[T]]:
        """Iterating waits for each sample, and ends after `close`, or when the Lab is closed.
        Raises what `next` raises, but no DeadlineMissed."""
        while True:
            try:
                sample = self.next()
            except DeadlineMissed:
                continue
            except EOFError:
                return
            yield sample

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _alive(self) -> bool:
        """Returns whether the stream is open and not silent. The caller holds the lock."""
        stream = self._stream
        if stream is None:
            return False
        if stream._is_event:
            return not (stream._is_gone or self._source.lab._closed)
        try:
            sample = stream.latest()
        except StreamLost:
            return False
        if sample is not None:
            return sample.age <= self._silence
        return time.monotonic() - self._heard < self._silence

    def _lose(self, why: str = "") -> None:
        """Drops the stream and its proxy, if there are any."""
        with self._lock:
            lost, proxy = self._stream, self._proxy
            self._stream = self._proxy = None
            if why or lost is not None:
                self._problem = why or f"'{self.name}' no longer sends samples"
        if lost is not None:
            lost.close()
        del proxy  # ends its session without the lock, because that may take some time

    def _connect(self, wait: float) -> None:
        """Opens the stream through a new proxy."""
        stream: Stream[T] | None = None
        problem = f"'{self.name}' sent no sample yet"
        try:
            proxy = self._source.connect(wait)
            stream = self._open(proxy)
        except FAILURES as error:
            problem = str(error)
            raise
        finally:
            with self._lock:
                self._heard = time.monotonic()
                self._next_try = self._heard + self._between_tries
                is_closed = self._closed.is_set()
                if not is_closed:
                    self._problem = problem
                    if stream is not None:
                        self._stream, self._proxy = stream, proxy
                        self._times_opened += 1
            if is_closed and stream is not None:
                stream.close()

    def _try_to_open(self, end: float) -> None:
        """Makes one attempt to open the stream, after the pause between two attempts. Raises the
        error of the attempt, unless the failure may disappear when a server or a broker starts."""
        pause = min(self._next_try, end) - time.monotonic()
        if self._closed.wait(max(0.0, pause)) or time.monotonic() < self._next_try:
            return
        try:
            self._connect(min(_SLICE, max(0.0, end - time.monotonic())))
        except FAILURES as error:
            if not may_pass(error):
                raise

    def _next_of(self, stream: Stream[T], end: float) -> Sample[T] | None:
        """Returns the next sample of `stream`. Returns None if no sample comes until `end`, if the
        stream is lost, silent or closed, or if the sample was read before the stream was opened
        again."""
        silent_at = math.inf if stream._is_event else self._heard + self._silence
        until = min(end, silent_at)
        try:
            sample = stream.next(None if until == math.inf else max(0.0, until - time.monotonic()))
        except DeadlineMissed:
            raise
        except TimeoutError:
            if time.monotonic() >= silent_at:
                self._lose()
            return None
        except StreamLost:
            self._lose()
            return None
        except EOFError:  # another thread has called `close`
            return None
        self._heard = time.monotonic()
        if (sample.sequence, sample.stamp) == self._read:
            return None
        self._read = (sample.sequence, sample.stamp)
        return sample
