"""The server's side of inward streams: a servant reads the samples that clients send."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from gecos import interface
from gecos.errors import ServeError
from gecos.wire import DecodeError, Decoder

if TYPE_CHECKING:
    from gecos_idl.object_types import FeedReport

    from gecos import _core
    from gecos.execution import Execution
    from gecos.servant import Servant

T = TypeVar("T")
# The most samples that one call of `next` or `newest` reads. Without this limit, a client that
# floods the stream would keep the servant in the call.
_MOST_LOOKS = 1024


@dataclass(frozen=True, slots=True)
class InwardSample(Generic[T]):
    """One value of an inward stream."""

    value: T
    sequence: int  # increases by one with each sample that its sender has sent
    stamp: float  # time of measurement for display: Unix time in s, by the sender's clock
    # The time in s from measurement to reading. The time is exact on one host; between hosts it is
    # too small by at most the shortest transit time of a packet.
    age: float
    session: int  # session of the sender, as Caller.session
    command: int  # number of the command that the sample feeds; 0: none


class Inward(Generic[T]):
    """The samples that clients send to an object on one inward stream. Only one thread reads at a
    time. Reading never waits.

    Each sample is judged when it is read. A sample has an effect only if its session is open and
    its sender has the status that the stream needs. The sample must also be younger than the
    watchdog and the lifespan of the stream. If the sample names a command that it is meant for,
    this command must be taking samples. All other samples are only counted. The samples of one
    client arrive in order. If a client sends more samples than the depth of the stream between two
    reads, the oldest of them are lost.
    """

    def __init__(self, servant: Servant, inward: interface.Inward[T]) -> None:
        self._servant = servant
        self._inward = inward
        self._code = inward.stream.code
        self._only_commands = False

    def next(self) -> InwardSample[T] | None:
        """Returns the oldest unread sample; None when there is none."""
        return next(self._unread(), None)

    def newest(self) -> InwardSample[T] | None:
        """Returns the newest unread sample and passes over the older ones; None when there is
        none."""
        sample = None
        for later in self._unread():
            sample = later
        return sample

    def _unread(self) -> Iterator[InwardSample[T]]:
        core = self._servant._gecos_core
        if core is None:
            return
        for _ in range(_MOST_LOOKS):
            raw = core.next_inward(self._code, self._only_commands)
            if raw is None:
                return
            value, sequence, stamp_ns, age_ns, session, command = raw
            try:
                decoded = self._inward.result(Decoder(value))
            except DecodeError as error:
                core.unreadable(self._code, session, str(error))
                continue
            yield InwardSample(decoded, sequence, stamp_ns * 1e-9, age_ns * 1e-9, session, command)

    @property
    def expired(self) -> bool:
        """True if every sample that was read is older than the watchdog time of the stream. When a
        command begins to take samples (`feeds`), the value is False for one watchdog time. Always
        False for a stream without a watchdog."""
        core = self._servant._gecos_core
        if core is None:
            return self._inward.stream.watchdog_ns > 0
        return core.inward_expired(self._code)

    def report(self) -> FeedReport:
        """Returns what became of the samples since the servant was added to its server."""
        from gecos_idl.object_types import FeedReport

        return FeedReport.decode(Decoder(self._served().inward_report(self._code)))

    def need_command(self) -> None:
        """From now on, refuses each sample that feeds no command. Without this call, such samples
        are refused only while a command takes samples."""
        self._only_commands = True

    @contextmanager
    def feeds(self, run: Execution[Any]) -> Iterator[None]:
        """Lets the command of a running handler take the samples during a `with` block. Samples
        that feed another command or no command are then refused. After the command is interrupted,
        all samples are refused. If several commands take samples, only the one that began last gets
        them."""
        core = self._served()
        feeding = core.begin_feeding(self._code, run._core)
        try:
            yield
        finally:
            core.end_feeding(self._code, feeding)

    def _served(self) -> _core.PulledServant:
        core = self._servant._gecos_core
        if core is None:
            raise ServeError(
                f"{self._servant._gecos_interface.name}.{self._inward.stream.name}: no samples"
                " come while the servant is not served; add it to a gecos.Server first"
            )
        return core
