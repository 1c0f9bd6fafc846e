"""The view that a handler has of the call that it executes: the caller, the cancellation and the
progress."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from gecos.wire import Contents, to_bytes

if TYPE_CHECKING:
    from gecos import _core

F = TypeVar("F")


@dataclass(frozen=True, slots=True)
class Caller:
    """The client that issued a call."""

    user: str
    host: str
    program: str
    pid: int
    session: int


class Execution(Generic[F]):
    """A running call of a cancelable operation with feedback of type F. Valid while its handler
    runs; afterwards, for example in a thread that the handler has started, everything here raises
    ValueError."""

    __slots__ = ("_core", "_feedback")

    def __init__(self, core: _core.IncomingCall, feedback: type | None = None) -> None:
        self._core = core
        self._feedback = feedback

    @property
    def interrupted(self) -> bool:
        """True if the handler should end soon and raise `gecos.Interrupted()`. The possible reasons
        are that the call was canceled or stopped, that the caller lost its lease, that the deadline
        passed, and that the server closes."""
        return self._core.interrupted()

    def wait_interrupted(self, seconds: float) -> bool:
        """Sleeps at most `seconds`. Returns True as soon as the call is interrupted. Raises
        ValueError if the handler returns meanwhile."""
        return self._core.wait_interrupted(seconds)

    def progress(self, fraction: float, feedback: F | None = None) -> None:
        """Reports progress, from 0 to 1, to the caller. Only the latest report is kept, so reports
        may be as frequent as you like. Raises TypeError for feedback of another type than the
        operation declares."""
        expected = self._feedback
        if feedback is not None and expected is not None and not isinstance(feedback, expected):
            raise TypeError(
                f"the feedback of run.progress must be a {expected.__name__}, not {feedback!r}: "
                f"`run.progress({fraction}, {expected.__name__}(…))`"
            )
        self._core.progress(fraction, b"" if feedback is None else _encoded(feedback))

    @property
    def caller(self) -> Caller:
        return Caller(*self._core.caller())


def _encoded(feedback: object) -> bytes:
    contents: Contents = feedback  # type: ignore[assignment]  # gidl only uses Contents types as F
    return to_bytes(contents)
