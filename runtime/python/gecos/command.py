"""Commands: calls that were issued and can be queried, waited for, awaited and canceled."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Generator
from dataclasses import dataclass
from types import GenericAlias
from typing import TYPE_CHECKING, Generic, Self

from gecos.callbacks import call, when_ended
from gecos.errors import (
    CommandFailed,
    ConnectionFailed,
    DeclaredError,
    Detail,
    State,
    UnobservedCommandWarning,
)
from gecos.task_of import TaskOf
from gecos.wire import DecodeError, Decoder

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    from gecos import _core
    from gecos.interface import Method

    T = TypeVar("T", covariant=True)
    F = TypeVar("F", covariant=True, default=None)
else:
    from typing import TypeVar

    T = TypeVar("T", covariant=True)
    F = TypeVar("F", covariant=True)


@dataclass(frozen=True, slots=True)
class Progress:
    """A consistent snapshot of a command's progress."""

    detail: Detail
    position: int  # number of commands ahead in the queue, while QUEUED
    fraction: float  # 0 to 1, as the server last reported


class Command(TaskOf[T], Generic[T, F]):
    """An issued call. T is the type of its result, and F is the type of the feedback from its
    handler.

    Issuing a call never blocks; only waiting does. A dropped command keeps running. A command is
    observed once the program asks for its state or result, waits for it, adds a callback, or
    cancels or detaches it. If a command that was never observed is dropped while it runs or after
    it failed, a warning is issued: one warning for each operation. Later failures of that operation
    are written to the log.
    """

    __slots__ = ("__weakref__", "_core", "_method")

    if not TYPE_CHECKING:
        __class_getitem__ = classmethod(GenericAlias)  # Command[T] is Command[T, None]

    def __init__(self, core: _core.Command, method: Method[T, F]) -> None:
        self._core = core
        self._method = method
        if method.operation.name not in _warned:
            self.__class__ = _Unobserved

    @property
    def state(self) -> State:
        """RUNNING, or the terminal state that the command has reached."""
        self._observe()
        return _STATES[self._core.progress()[0]]

    @property
    def id(self) -> str:
        """The command's id, three hexadecimal numbers. After a lost connection, pass it to
        `gecos.outcome`.

        Any program that knows the id may ask for the outcome of the command.
        """
        return self._core.id()

    def progress(self) -> Progress:
        self._observe()
        detail, position, fraction = self._core.progress()
        return Progress(Detail(detail), position, fraction)

    def feedback(self) -> F | None:
        """The latest feedback of the running command. None before the first feedback, and if the
        latest feedback cannot be decoded."""
        self._observe()
        decode = self._method.feedback
        raw = self._core.feedback() if decode is not None else b""
        try:
            return decode(Decoder(raw)) if decode is not None and raw else None
        except DecodeError:
            return None

    def wait(self, timeout: float | None = None) -> State:
        """Waits at most `timeout` seconds until the command is terminal. Returns its state."""
        self._observe()
        self._core.wait(timeout)
        return self.state

    def result(self, timeout: float | None = None) -> T:
        """Waits for the result and returns it.

        If the command failed, raises a declared exception, CommandFailed or ConnectionFailed. If
        the command still runs after `timeout` seconds, raises TimeoutError; the command keeps
        running.
        """
        self._observe()
        answer = self._core.answer(timeout)
        if isinstance(answer, int):
            if _STATES[answer] is State.RUNNING:
                raise TimeoutError(f"{self._name} is still running after {timeout} s")
            raise self._failure()
        try:
            return self._method.decode_reply(answer)
        except DecodeError as error:
            raise CommandFailed(
                Detail.FAULT, f"{self._name}: the reply does not decode: {error}"
            ) from error

    def exception(self) -> CommandFailed | ConnectionFailed | None:
        """The reason why the command failed. None while the command runs, and if it finished."""
        failed = self.state in (State.COMMAND_FAILED, State.CONNECTION_FAILED)
        return self._failure() if failed else None

    def cancel(self) -> None:
        """Asks the server to stop the command. The final state shows whether the request came in
        time."""
        self._observe()
        self._core.cancel()

    def detach(self) -> None:
        """Detaches the command: it keeps running, no warning is issued when it is dropped or fails,
        and its failure does not prevent commands that are issued later."""
        self._observe()
        self._core.ignore_outcome()

    def fileno(self) -> int:
        """Returns a descriptor that becomes readable once the command is terminal, for `select` and
        similar functions.

        The command owns the descriptor: keep the command as long as the descriptor is watched.
        """
        self._observe()
        return self._core.descriptor()

    def add_done_callback(self, callback: Callable[[Self], object]) -> None:
        """Calls `callback(command)` once the command is terminal, even if it was dropped.

        Callbacks run one after another on a dedicated thread, or at once on the calling thread if
        the command has already ended. Callbacks may block and issue commands; their exceptions are
        logged.
        """
        if Detail(self._core.peek()[0]).state is State.RUNNING:
            when_ended(self, lambda: callback(self))
        else:
            call(lambda: callback(self))

    def __await__(self) -> Generator[object, None, T]:
        return self._awaited().__await__()

    async def _awaited(self) -> T:
        self._observe()
        if self.state is State.RUNNING:
            await _readable(self.fileno())
        return self.result()

    def _failure(self) -> CommandFailed | ConnectionFailed:
        return self._as_error(self._core.failure())

    def _as_error(self, failure: tuple[int, str, str, bytes]) -> CommandFailed | ConnectionFailed:
        number, text, exception, evidence = failure
        detail = Detail(number)
        if detail.state is State.CONNECTION_FAILED:
            return ConnectionFailed(detail, text)
        if exception:
            return _declared(self._method.raises, exception, evidence, text)
        return CommandFailed(detail, text)

    @property
    def _name(self) -> str:
        return self._method.operation.name

    def __repr__(self) -> str:
        if self._core.inherited():
            return f"<Command {self._name}: of the process that forked this one>"
        detail, position, fraction = self._core.peek()
        more = f", {position} before it" if detail == Detail.QUEUED else ""
        more += f", {fraction:.0%}" if detail == Detail.EXECUTING else ""
        if Detail(detail).state in (State.COMMAND_FAILED, State.CONNECTION_FAILED):
            more = f": {self._core.peek_failure()[1]}"
        return f"<Command {self._name}: {Detail(detail).name}{more}>"

    def _observe(self) -> None:
        """Marks the command as observed. `_Unobserved` overrides this method, which does nothing
        here."""


class _Unobserved(Command[T, F]):
    """A command that was not observed yet. Only this class has a `__del__`, because Python loses a
    Ctrl-C that arrives during a `__del__`. A loop such as `while True: oven.temperature().result()`
    drops an observed command in each round, so Ctrl-C could otherwise fail to end the loop."""

    __slots__ = ()

    def _observe(self) -> None:
        self.__class__ = Command  # type: ignore[assignment]  # the class without `__del__`

    def __del__(self) -> None:
        if self._name in _warned or self._core.inherited():
            return  # a warning was already issued, or the parent of this process issues it
        detail = Detail(self._core.peek()[0])
        # If the server did not carry out a command because an earlier command had failed, the core
        # marks the later command as observed. Only the earlier command causes a warning.
        if detail is Detail.DONE or self._core.observed():
            return
        _warned.add(self._name)
        if detail.state is State.RUNNING:
            what = f"{self._name}: dropped while it was running, so nobody would notice a failure"
        else:
            about = self._core.about() or self._name
            # The warning shows the failure, so the log need not show it. `peek_failure` reads the
            # failure without telling the server that the program has seen it.
            self._core.observe()
            failure = self._as_error(self._core.peek_failure())
            what = f"{about} failed, and nobody observed the failure: {failure}"
        warnings.warn(
            f"{what}; keep the command and wait() for it, or detach() it",
            UnobservedCommandWarning,
            stacklevel=2,  # the line that drops the command, usually the line that issued it
        )


_STATES = tuple(detail.state for detail in Detail)  # index: the number of the detail
_warned: set[str] = set()


def _declared(
    raises: tuple[type[DeclaredError], ...], name: str, evidence: bytes, text: str
) -> CommandFailed:
    for kind in raises:
        if kind._gecos_name == name:
            decode: Callable[[Decoder], DeclaredError] = kind.decode
            try:
                return decode(Decoder(evidence))
            except DecodeError as error:
                return CommandFailed(
                    Detail.FAULT, f"{text} (the exception cannot be decoded: {error})"
                )
    return CommandFailed(Detail.FAULT, text)


async def _readable(descriptor: int) -> None:
    """Waits in the running event loop until `descriptor` is readable. Several tasks may wait for
    the same descriptor."""
    import asyncio

    loop = asyncio.get_running_loop()
    ready = loop.create_future()
    own = os.dup(descriptor)
    try:
        loop.add_reader(own, lambda: None if ready.done() else ready.set_result(None))
        try:
            await ready
        finally:
            loop.remove_reader(own)
    finally:
        os.close(own)
