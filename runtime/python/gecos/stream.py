"""A subscription to an outward stream or an event. A program reads its newest sample, or every
sample in order."""

from __future__ import annotations

import contextlib
import copy
import threading
import time
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass, replace
from types import TracebackType
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

from gecos.errors import DeadlineMissed, StreamLost, StreamRevoked
from gecos.in_place import SampleInPlace
from gecos.wire import DecodeError, Decoder
from gecos.wire.plans import from_start

if TYPE_CHECKING:
    from gecos import _core
    from gecos.listener import Listener
    from gecos.reader import Turn
    from gecos.wire.in_place import OctetsInPlace

T = TypeVar("T")
_MOMENT = 0.01  # s for which one attempt waits for the stream's lock


@dataclass(frozen=True, slots=True)
class Sample(Generic[T]):
    """One value of a stream."""

    value: T
    sequence: int  # increases by one with each published sample
    # The number of samples that were published after the previously read sample and before this
    # one. The first sample of a subscription to a stream has 0 here. The first event of a
    # subscription has the number of earlier events that were sent after the subscription.
    lost: int
    stamp: float  # time of measurement for display: Unix time in s, by the server's clock
    # The time in s from measurement to reading. Setting a clock does not change the age. The age is
    # exact on one host; between hosts it is at most one round-trip time too large, and never too
    # small.
    age: float


@dataclass(frozen=True, slots=True)
class StreamCounts:
    """The counts of the samples of one subscription, and of the deadlines that its stream
    missed."""

    received: int  # samples that were read, each counted once
    lost: int  # samples that were overwritten before they were read, or lost on the way
    skipped: int  # samples that `latest` passed over, because it returned a newer one
    expired: int  # samples that were not returned, because they were older than the lifespan
    missed_deadlines: int  # periods of the deadline that passed without a sample


class Stream(Generic[T]):
    """The samples of a subscription in order, starting with the newest sample, or with the first
    event after the subscription. A slow reader loses old samples, which `Sample.lost` counts. A
    sample that is older than the lifespan of the stream is never returned; `counts` counts it. A
    sample that cannot be decoded is skipped, and `unreadable` counts it. `Sample.lost` also counts
    such a sample if it belongs to an event, or if it was published after the first sample that was
    read.

    Iterating waits for each sample, and ends after `close()`. It raises StreamLost if the server is
    gone or silent or has closed the session, or if the Lab is closed; if the server no longer
    admits this user, it raises the subclass StreamRevoked. Only one thread or task reads
    at a time: other threads wait in `next`, within their timeout, and their calls of `latest` raise
    RuntimeError.

    `async for` waits on a dedicated thread. Cancelling the `async for` loses no sample: a sample
    that was already received goes to the next reader, or counts as lost if a later sample was read
    before.
    """

    def __init__(
        self,
        core: _core.Stream,
        decode: Callable[[Decoder], T],
        name: str,
        in_place: OctetsInPlace | None = None,
    ) -> None:
        self._core = core
        self._octets = in_place
        self._decode = from_start(decode)
        self._name = name
        self._reading = threading.Lock()
        self._waits = False  # True while a reader waits for a sample
        self._turn: Turn[T] | None = None  # the awaiting reader in an `async for`
        self._listened = False  # True once a Listener reads
        self._closed = False
        self._is_lost = False
        self._after = core.after
        self._read = self._after  # sequence number of the last sample that was read
        self._measured_ns = 0  # time stamp of the last sample that was read
        self._returned: deque[Sample[T]] = deque()  # samples whose readers were cancelled
        # The sample that was read last, if its reader was cancelled and has returned it.
        self._unread: Sample[T] | None = None
        # Samples that count as lost, because a cancelled reader returned them after another reader
        # had read a later sample. Samples that were lost before such a sample count, too.
        self._missed = 0
        self._last_unreadable = 0
        self._unreadable = 0

    def latest(self) -> Sample[T] | None:
        """Returns the newest sample, even if it was read before. Returns None before the first
        sample, if the newest sample cannot be decoded or is older than the lifespan, while the
        writer is not `alive`, and after `close()`. Never waits for a sample.

        Raises StreamLost if the server is gone or silent, or if the Lab was closed. A silent server
        is noticed only after 1.3 s. Until then, only `age` shows that no new samples arrive. Raises
        RuntimeError while another thread or task waits in `next` of the same stream.
        """
        with self._turn_to_look():
            raw = self._core.latest()
            if isinstance(raw, str):
                raise self._lost(raw)
            return None if raw is None else self._sample(*raw)

    def latest_in_place(self) -> SampleInPlace[T] | None:
        """Returns the newest sample as `latest` does, but without a copy of its @bulk octets.
        Raises TypeError if the samples of this stream have none, or several @bulk members."""
        self._need_octets()
        with self._turn_to_look():
            raw = self._core.latest_in_place()
            if isinstance(raw, str):
                raise self._lost(raw)
            return None if raw is None else self._in_place(*raw)

    def next_in_place(self, timeout: float | None = None) -> SampleInPlace[T]:
        """Returns the next unread sample as `next` does, but without a copy of its @bulk octets.
        Raises TypeError as `latest_in_place` does."""
        self._need_octets()
        sample = self._next(timeout, None, self._core.next_in_place, self._in_place)
        if sample is None:
            raise EOFError(f"stream {self._name} was closed")
        return sample if isinstance(sample, SampleInPlace) else self._as_in_place(sample)

    def _need_octets(self) -> None:
        if self._octets is None:
            raise TypeError(
                f"stream {self._name} is not read in place: its samples have no @bulk "
                "sequence<octet>, or several @bulk members; use next() or latest()"
            )

    @contextlib.contextmanager
    def _turn_to_look(self, call: str = "latest()") -> Iterator[None]:
        """Makes this thread the only reader of the stream, for one read that does not wait for a
        sample. `call` is the read, for the error text."""
        while self._occupied() or not self._reading.acquire(timeout=_MOMENT):
            self._refuse_a_forked_child()
            if self._occupied():
                raise RuntimeError(
                    f"stream {self._name}: {call} would block, because another thread or task "
                    "waits for the next sample; open a stream for each thread or task"
                )
        try:
            self._look_back()
            yield
        finally:
            self._reading.release()

    def next(self, timeout: float | None = None) -> Sample[T]:
        """Returns the next unread sample. A program that reads more slowly than the server
        publishes gets old samples; call `latest()` for the current value.

        Raises TimeoutError after `timeout` seconds without a sample, its subclass DeadlineMissed
        once for each silence that is longer than the deadline of the stream, EOFError if the stream
        was closed, and StreamLost if the server is gone or the Lab was closed. Loops over the
        stream do not raise DeadlineMissed, and go on.
        """
        sample: Sample[T] | None = self._next(timeout)
        if sample is None:
            raise EOFError(f"stream {self._name} was closed")
        return sample

    def listen(
        self,
        callback: Callable[[Sample[T]], object],
        ended: Callable[[StreamLost], object] | None = None,
    ) -> Listener[T]:
        """Calls `callback` for each sample from the next unread one on, on a dedicated thread,
        until the returned Listener or this stream is closed. From now on no other thread may read
        the stream.

        Once the stream is lost, `ended` is called once, with the exception that `next` would raise;
        then nothing more is called. `ended` is not called after `close()`. Without `ended`, the log
        reports the loss, except when the program closed the Lab. If one of the functions raises an
        exception, the log reports it, and the Listener goes on. A missed deadline is not reported.

        Raises RuntimeError if the stream has a Listener, and once the program is ending.
        """
        from gecos.listener import Listener  # not at the top, because few programs need it

        if self._listened:
            raise RuntimeError(
                f"stream {self._name} has a Listener already; open a stream for each Listener"
            )
        self._listened = True
        return Listener(self, callback, ended)

    def history(self) -> list[Sample[T]]:
        """Returns the samples that are kept now, oldest first: at most as many as the depth of the
        stream, and none that is older than its lifespan. Never waits for a sample. Leaves unchanged
        which sample `next` returns next, and `counts`. `Sample.lost` is the number of samples
        missing between two samples of the history.

        Over inproc and shm, a history has the newest samples of the server, also those that were
        published before the subscription, but after the first subscription of any client over this
        medium. Over lcm, it has the samples that this reader has received, from the newest one at
        the subscription on. The history of an event begins after the subscription, over every
        medium. After a loss of the stream, the history stays, and no sample comes into it after the
        first look that found the loss; after `close()`, and after the Lab was closed, it is empty.
        When the proxy has moved to another medium (`on_degraded="failover"`), the history begins
        again with the samples that the new medium keeps; until all samples of the old medium were
        read, the history has the samples of both.

        Raises RuntimeError while another thread or task waits in `next` of the same stream.
        """
        kept: list[Sample[T]] = []
        with self._turn_to_look("history()"):
            for raw, sequence, stamp_ns, measured_ns in self._core.history():
                with contextlib.suppress(DecodeError):
                    value = self._decode(raw)
                    lost = sequence - kept[-1].sequence - 1 if kept else 0
                    kept.append(
                        Sample(value, sequence, lost, stamp_ns * 1e-9, age=_age(measured_ns))
                    )
        return kept

    @property
    def unreadable(self) -> int:
        """The number of received samples that cannot be decoded. Such samples come from a faulty
        server: if the server only had another sample type, opening the stream would have failed."""
        return self._unreadable

    @property
    def counts(self) -> StreamCounts:
        """The counts of the samples since the first one that was read. Any thread may read this
        property, even after `close()`."""
        return StreamCounts(*self._core.counts())

    @property
    def alive(self) -> bool:
        """True if the writer was alive when the stream was last read. False once the stream is lost
        or closed. With `@qos(liveliness=MANUAL)`, also False from a missed deadline until the next
        sample."""
        return self._core.alive()

    @property
    def _is_event(self) -> bool:
        return self._after is not None

    @property
    def _is_gone(self) -> bool:
        """True once the session of the stream is lost. False after the Lab was closed."""
        return self._core.loss_text() != ""

    def __iter__(self) -> Iterator[Sample[T]]:
        while True:
            try:
                sample = self._next(None)
            except DeadlineMissed:
                continue
            if sample is None:
                return
            yield sample

    def __aiter__(self) -> AsyncIterator[Sample[T]]:
        from gecos.reader import SampleReader  # not at the top, because importing asyncio is slow

        return SampleReader(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Ends the subscription. A waiting `next` raises EOFError. The end of a `with` block of the
        stream does the same."""
        self._closed = True
        self._core.close()

    def _next(
        self,
        timeout: float | None,
        turn: Turn[T] | None = None,
        wait: Callable[[float | None], Any] | None = None,
        made: Callable[..., Any] | None = None,
    ) -> Any:
        """Returns the next sample, which `wait` reads and `made` decodes; None after `close()`."""
        wait, made = wait or self._core.next, made or self._sample
        end = None if timeout is None else time.monotonic() + timeout
        patience = -1 if timeout is None else min(max(0.0, timeout), threading.TIMEOUT_MAX)
        if not self._reading.acquire(blocking=False):
            self._refuse_a_forked_child()
            if not self._reading.acquire(timeout=patience):
                raise TimeoutError(
                    f"stream {self._name}: no sample within {timeout} s, because another thread or "
                    "task was waiting for a sample all that time"
                )
        try:
            self._turn, self._waits = turn, True
            sample = self._returned_one()
            left = None if end is None else end - time.monotonic()
            while sample is None:
                raw = wait(left)
                if raw == "closed":
                    return None
                if raw in ("lost", "revoked"):
                    raise self._lost(raw)
                if raw == "late":
                    raise DeadlineMissed(
                        f"stream {self._name}: no sample came within its deadline; "
                        "the stream continues"
                    )
                if raw == "nothing":
                    break
                sample = made(*raw)
                if sample is None and end is not None and (left := end - time.monotonic()) <= 0:
                    break
            if sample is not None:
                if turn is not None:
                    turn.taken.append(sample)
                    if turn.over:  # the reader was cancelled in the meantime
                        self._take_back(turn)
                return sample
        finally:
            self._waits, self._turn = False, None
            self._reading.release()
        raise TimeoutError(f"stream {self._name}: no sample within {timeout} s")

    def _refuse_a_forked_child(self) -> None:
        """Raises RuntimeError in a child that was forked while a thread of its parent was reading.
        The child has inherited the lock of this thread, and no thread that could release it."""
        self._core.alive()

    def _occupied(self) -> bool:
        turn = self._turn
        return self._waits and not (turn is not None and turn.over)

    def _take_back(self, turn: Turn[T]) -> None:
        """Keeps a sample that a cancelled reader received but did not use. Any thread may call this
        method."""
        with contextlib.suppress(IndexError):
            self._returned.append(turn.taken.pop())

    def _look_back(self) -> None:
        """Takes over the samples that cancelled readers returned. Only the thread or task that
        reads may call this method."""
        while self._returned:
            sample = self._returned.popleft()
            if sample.sequence == self._read:
                self._unread = sample
            else:
                self._missed += 1 + sample.lost

    def _returned_one(self) -> Sample[T] | None:
        self._look_back()
        if self._unread is None or self._closed:
            return None
        sample, self._unread = self._unread, None
        return replace(sample, age=_age(self._measured_ns))

    def __repr__(self) -> str:
        state = "closed" if self._closed else "lost" if self._is_lost else "open"
        read = "none" if self._read == self._after else self._read
        return f"<Stream {self._name}: {state}, last sample read: {read}>"

    def _lost(self, how: str) -> StreamLost:
        self._is_lost = True
        why = self._core.loss_text() or "its Lab is closed"
        if how == "revoked":
            return StreamRevoked(f"stream {self._name}: {why}")
        return StreamLost(
            f"stream {self._name}: {why}; create a new proxy and open the stream again"
        )

    def _sample(
        self, raw: bytes, sequence: int, stamp_ns: int, measured_ns: int
    ) -> Sample[T] | None:
        try:
            value = self._decode(raw)
        except DecodeError:
            self._note_unreadable(sequence)
            return None
        lost = self._note_read(sequence, measured_ns)
        return Sample(
            value=value,
            sequence=sequence,
            lost=lost,
            stamp=stamp_ns * 1e-9,
            age=_age(measured_ns),
        )

    def _in_place(
        self, memory: _core.LentSample, sequence: int, stamp_ns: int, measured_ns: int
    ) -> SampleInPlace[T] | None:
        assert self._octets is not None
        try:
            value, octets = self._octets.decode(memoryview(memory))
        except DecodeError:
            # Octets that the publisher has begun to overwrite do not make a sample unreadable.
            if memory.intact():
                self._note_unreadable(sequence)
            return None
        if not memory.intact():
            return None
        lost = self._note_read(sequence, measured_ns)
        return SampleInPlace(
            value, octets, sequence, lost, stamp_ns * 1e-9, _age(measured_ns), memory
        )

    def _as_in_place(self, sample: Sample[T]) -> SampleInPlace[T]:
        """Converts a sample that a cancelled reader has returned."""
        assert self._octets is not None
        name = self._octets.attribute
        octets = memoryview(getattr(sample.value, name))
        value = copy.copy(sample.value)
        setattr(value, name, b"")
        return SampleInPlace(
            value, octets, sample.sequence, sample.lost, sample.stamp, sample.age, None
        )

    def _note_unreadable(self, sequence: int) -> None:
        self._unreadable += sequence != self._last_unreadable
        self._last_unreadable = sequence

    def _note_read(self, sequence: int, measured_ns: int) -> int:
        """Returns the number of samples that were lost before this one."""
        lost = self._unread.lost if self._unread is not None else 0
        if sequence != self._read:
            lost += self._missed + (self._unread is not None)
            lost += 0 if self._read is None else sequence - self._read - 1
            self._missed = 0
        self._read, self._unread, self._measured_ns = sequence, None, measured_ns
        return lost


def _age(measured_ns: int) -> float:
    return max(0, time.clock_gettime_ns(time.CLOCK_BOOTTIME) - measured_ns) * 1e-9
