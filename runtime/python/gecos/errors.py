"""The exceptions of gecos. Each derives from a built-in exception with a similar meaning.

Generated exceptions derive from `DeclaredError`. Modules of generated types import only this module
and the codec.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import Field, dataclass, fields, is_dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar, Self

from gecos.wire import HIDDEN
from gecos.wire.enums import printed_by_name
from gecos.wire.units import mistaken_unit, shown_members

if TYPE_CHECKING:
    from gecos_idl.object_types import Holder

    from gecos.wire import Decoder, Parts


@printed_by_name
class State(IntEnum):
    """The four states of a command. A command reaches exactly one of the last three, and then its
    state never changes."""

    RUNNING = 0
    FINISHED = 1
    COMMAND_FAILED = 2
    CONNECTION_FAILED = 3  # the command did not start, so sending it again is safe


@printed_by_name
class Detail(IntEnum):
    """The detailed state of a command. `state` tells to which of the four states a detail belongs.
    The numbers equal those of `gecos::Detail` in C++."""

    SENT = 0
    QUEUED = 1
    EXECUTING = 2
    CANCELING = 3
    UNREACHABLE = 4
    DONE = 5
    REJECTED = 6
    BAD_PARAMETER = 7
    UNKNOWN_OPERATION = 8
    DENIED = 9
    QUEUE_FULL = 10
    EXPIRED = 11
    TIMED_OUT = 12
    FAULT = 13
    CANCELED = 14
    PREEMPTED = 15
    STOPPED = 16
    LEASE_LOST = 17
    PRESENCE_LOST = 18
    SERVER_CRASHED = 19
    OUTCOME_UNKNOWN = 20
    NOT_STARTED = 21
    NO_SERVER = 22
    REFUSED = 23
    QOS_UNAVAILABLE = 24

    @property
    def state(self) -> State:
        if self < Detail.DONE:
            return State.RUNNING
        if self == Detail.DONE:
            return State.FINISHED
        return State.COMMAND_FAILED if self < Detail.NOT_STARTED else State.CONNECTION_FAILED


class CommandFailed(RuntimeError):
    """The command was not executed, or was not completed. `detail` classifies the failure, and
    `text` gives the reason."""

    _detail: Detail = Detail.FAULT

    def __init__(self, detail: Detail, text: str) -> None:
        super().__init__(detail, text)
        self._detail = detail
        self._text = text

    @property
    def detail(self) -> Detail:
        return self._detail

    @property
    def text(self) -> str:
        return self._text

    def __str__(self) -> str:
        return f"{self.detail.name}: {self.text}"

    def __reduce__(self) -> tuple[Any, ...]:
        """Lets copies and pickles keep all attributes, whatever the parameters of the constructor
        are."""
        return _made_again, (type(self), self.args, {}), vars(self) or None


def _made_again(
    kind: type[CommandFailed], args: tuple[object, ...], members: dict[str, object]
) -> CommandFailed:
    error = kind.__new__(kind)
    error.args = args
    for name, value in members.items():
        setattr(error, name, value)
    return error


class DeclaredError(CommandFailed):
    """An exception that an interface declares. The handler raises it in the server, and the command
    raises it again in the client.

    Each generated class is a dataclass (`eq=False`) and encodes itself.
    """

    _gecos_name: ClassVar[str] = ""  # scoped name, for example "robcl::OutOfReach"
    _gecos_units: ClassVar[Mapping[str, str]] = {}  # the units of members that have a unit

    if TYPE_CHECKING:
        # mypy does not see the constructor that @dataclass makes for an exception without members.
        def __init__(self) -> None: ...
    else:

        def __new__(cls, *members: object, **named: object) -> Self:
            # The base class gets no arguments: it would keep them in `args`, where secret members
            # would be visible.
            return super().__new__(cls)

    @property
    def text(self) -> str:
        return str(self)

    def __str__(self) -> str:  # must not use `text`: the exception may have a member `text`
        values = {
            member.name: repr(getattr(self, member.name)) if member.repr else HIDDEN
            for member in self._gecos_members()
        }
        units = self._gecos_units
        shown = f"{self._gecos_name}({shown_members(values, units)})"
        if {"value", "lower", "upper"} <= units.keys() and not self._gecos_is_computed():
            value, low, high = (getattr(self, name) for name in ("value", "lower", "upper"))
            shown += mistaken_unit(value, low, high, units["value"])
        return shown

    def _gecos_is_computed(self) -> bool:
        """Returns whether an optional member of the exception has a value. Such a member says how
        the object computed the member `value`. A computed number cannot be an input that the caller
        gave in a wrong unit."""
        return any(
            member.default is None and getattr(self, member.name) is not None
            for member in self._gecos_members()
        )

    def __reduce__(self) -> tuple[Any, ...]:
        members = {m.name: getattr(self, m.name) for m in self._gecos_members()}
        return _made_again, (type(self), self.args, members), vars(self) or None

    @classmethod
    def _gecos_members(cls) -> tuple[Field[Any], ...]:
        return fields(cls) if is_dataclass(cls) else ()

    def encode(self, out: Parts, /) -> None:
        raise NotImplementedError(f"{type(self).__name__} is not a generated exception")

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        raise NotImplementedError(f"{cls.__name__} is not a generated exception")

    @staticmethod
    def fingerprint() -> int:
        raise NotImplementedError("not a generated exception")


class Rejected(CommandFailed):
    """A handler raises this exception to refuse a command. Its text tells the caller what to do."""

    def __init__(self, text: str) -> None:
        super().__init__(Detail.REJECTED, text)


class Interrupted(CommandFailed):
    """A handler raises this exception when it ends early because `run.interrupted` is True."""

    def __init__(self) -> None:
        super().__init__(Detail.CANCELED, "canceled")


class ConnectionFailed(ConnectionError):
    """The connection failed and the command certainly did not start, so sending it again is
    safe."""

    def __init__(self, detail: Detail, text: str) -> None:
        super().__init__(detail, text)
        self.detail = detail
        self.text = text

    def __str__(self) -> str:
        return f"{self.detail.name}: {self.text}"


@dataclass(frozen=True, slots=True)
class Attempt:
    """A name to which `create` could not connect, and the reason."""

    name: str
    detail: Detail  # NO_SERVER, REFUSED or QOS_UNAVAILABLE
    reason: str
    silent_since: float | None = None  # Unix time, if the broker no longer hears the server


class CreateError(ConnectionError):
    """No object could be reached. `attempts` has the reason for each name that was tried."""

    def __init__(self, attempts: Sequence[Attempt]) -> None:
        super().__init__(attempts)
        self.attempts = tuple(attempts)

    def __str__(self) -> str:
        reasons = (
            f"{a.name}{': ' if a.name else ''}{a.detail.name}: {a.reason}" for a in self.attempts
        )
        return "; ".join(reasons) or "create was given no name"


class LeaseRefused(PermissionError):
    """Actor or master status was not granted; `holders` lists the clients that have it."""

    def __init__(self, text: str, holders: Sequence[Holder] = ()) -> None:
        super().__init__(text)
        self.holders = tuple(holders)


class StreamLost(ConnectionError):
    """The server of a stream is gone or silent, or the Lab of its reader was closed."""


class StreamRevoked(StreamLost):
    """The server of a stream ended its session, because it no longer admits this user."""


class DeadlineMissed(TimeoutError):
    """No sample of a stream came within the deadline that its interface declares. The stream
    continues."""


class ServeError(RuntimeError):
    """An object cannot be served under its name."""


class UnobservedCommandWarning(RuntimeWarning):
    """A command was dropped while it ran or after it failed, and no code observed its outcome."""


class DroppedLeaseWarning(RuntimeWarning):
    """A lease was dropped, and so released, before any command was issued under it."""


_MAY_PASS = {
    Detail.NO_SERVER,
    Detail.NOT_STARTED,
    Detail.SERVER_CRASHED,
    Detail.OUTCOME_UNKNOWN,
}


def may_pass(error: CreateError | CommandFailed | ConnectionFailed) -> bool:
    """Returns whether the failure of a connection may disappear when an object or a broker is
    started."""
    if isinstance(error, CreateError):
        return any(attempt.detail in _MAY_PASS for attempt in error.attempts)
    return error.detail in _MAY_PASS
