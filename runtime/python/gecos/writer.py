"""The client's side of inward streams: a program sends samples to an object."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Any, Generic, NoReturn, Self, TypeVar

from gecos.command import Command
from gecos.errors import CommandFailed, ConnectionFailed, Detail, State
from gecos.interface import Inward
from gecos.stamp import in_ns
from gecos.unopened import Unopened

if TYPE_CHECKING:
    from gecos_idl.object_types import FeedReport

    from gecos import _core
    from gecos.proxy import Object

T = TypeVar("T")


class InwardAttribute(Unopened, Generic[T]):
    """An attribute to which clients send samples. `writer()` opens its stream."""

    __slots__ = ("_inward", "_object")

    def __init__(self, owner: Object, inward: Inward[T]) -> None:
        self._object = owner
        self._inward = inward

    def _to_open(self) -> str:
        name = self._inward.stream.name
        return (
            f"{self._object!r}: {name} is an inward stream; open it first with `.{name}.writer()`"
        )

    def __call__(self, *_given: object, **_named: object) -> NoReturn:
        """Raises TypeError: samples are sent by a writer."""
        name = self._inward.stream.name
        raise TypeError(
            f"{self._object!r}: {name} is an inward stream; open it with `.{name}.writer()` and "
            "send samples with `send`"
        )

    def __repr__(self) -> str:
        return f"<inward stream {self._inward.stream.name} of {self._object!r}>"

    def writer(self) -> Writer[T]:
        """Opens the stream. Raises ConnectionFailed or CommandFailed if this fails."""
        # The first array that is encoded needs numpy, whose import takes 100 ms and more. A
        # watchdog would not wait so long for the first sample.
        import numpy  # noqa: F401

        session = self._object._gecos_session
        opened = session.open_writer(self._inward.stream.code)
        name = f"{session.object_name}.{self._inward.stream.name}"
        if isinstance(opened, tuple):
            _raise(name, *opened)
        return Writer(session, opened, self._inward, name)


class Writer(Generic[T]):
    """Sends samples to an object on one inward stream. Only one thread sends at a time. A session
    has one writer for each stream: after a program opens another writer, the server no longer reads
    the samples of the earlier one.

    The server judges each sample when the servant reads it, and counts the samples that have no
    effect. `report()` asks for these counts. Sending never waits for the server.
    """

    def __init__(
        self, session: _core.Session, core: _core.Writer, inward: Inward[T], name: str
    ) -> None:
        self._session = session
        self._core = core
        self._inward = inward
        self._name = name

    def send(self, value: T, stamp: float | None = None) -> None:
        """Sends one sample under the session's present status. `stamp` is when the value was
        measured, in s of Unix time; None: now.

        Raises EncodeError if the value is out of its range or does not fit the type, CommandFailed
        if the stream needs a status that the session does not have, and ConnectionFailed if the
        session is lost or the writer is closed. Nothing is sent then.
        """
        refused = self._core.send(b"".join(self._inward.body(value)), in_ns(stamp))
        if refused is not None:
            _raise(self._name, *refused)

    def feeds(self, command: Command[Any, Any] | None) -> None:
        """Makes each further sample feed `command`: the sample has an effect only while `command`
        runs and takes samples. If `command` is None, further samples feed no command. Raises
        TypeError if `command` is neither a command nor None."""
        if not isinstance(command, Command | None):
            raise TypeError(
                f"feeds takes the command that the samples feed, or None, not {command!r}"
            )
        self._core.feeds(None if command is None else command.id)

    def report(self) -> Command[FeedReport]:
        """Asks the server what became of the samples that this session has sent."""
        from gecos.builtin_operations import feed_report

        return feed_report(self._session, self._inward.stream.code)

    @property
    def lost(self) -> bool:
        """True if the server is gone or has closed the session, or the Lab or the writer is
        closed."""
        return self._core.lost()

    def close(self) -> None:
        """Ends the stream. The end of a `with` block of the writer does the same."""
        self._core.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Writer {self._name}: {'lost' if self.lost else 'open'}>"


def _raise(name: str, number: int, text: str) -> NoReturn:
    detail = Detail(number)
    if detail.state is State.CONNECTION_FAILED:
        raise ConnectionFailed(detail, f"{name}: {text}")
    raise CommandFailed(detail, f"{name}: {text}")
