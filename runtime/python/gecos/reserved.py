"""What every object answers, whatever its interface: functions, so that nothing can clash."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from gecos.command import Command
from gecos.errors import Detail, State
from gecos.interface import Access, Method, Operation, nothing
from gecos.proxy import Object
from gecos.wire import Decoder

if TYPE_CHECKING:
    from gecos_idl.object_types import Description, Holder

T = TypeVar("T")


def stop(robot: Object) -> Command[None]:
    """Stops the device, whoever moves it: ends leases, drops the queue, interrupts what runs."""
    return _call(robot, 2, "stop", nothing)


def ping(robot: Object) -> Command[None]:
    """Finishes when the object's session has answered."""
    return _call(robot, 3, "ping", nothing)


def describe(robot: Object) -> Command[Description]:
    """What the object is and what state it is in."""
    from gecos_idl.object_types import Description

    return _call(robot, 4, "describe", lambda body: Description.decode(body.block("describe")))


def holders(robot: Object) -> Command[list[Holder]]:
    """Who holds actor or master status."""
    return _call(robot, 1, "holders", _holders)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a command, or where it stands."""

    detail: Detail
    text: str  # why, when it is not DONE

    @property
    def state(self) -> State:
        return self.detail.state


def outcome(robot: Object, command: str) -> Command[Outcome]:
    """What became of the actor command with this id, whose own outcome is OUTCOME_UNKNOWN.

    Asked through a new proxy; the state of the command itself never changes. NOT_STARTED is a
    promise: what has not arrived by now never starts. SENT: it has not arrived and may still start;
    ask again. OUTCOME_UNKNOWN: the server was started anew
    since, or keeps it no more (it keeps the last 1024 of each object). Raises ValueError for what
    is no id.
    """
    operation = Operation(code=9, name="outcome", access=Access.SENSOR)
    core = robot._gecos_session.outcome(command)
    return Command(core, Method[Outcome, None](operation, _outcome))


def _call(robot: Object, code: int, name: str, result: Callable[[Decoder], T]) -> Command[T]:
    operation = Operation(code=code, name=name, access=Access.SENSOR)
    return Command(robot._gecos_session.reserved(code), Method[T, None](operation, result))


def _outcome(source: Decoder) -> Outcome:
    from gecos_idl.object_types import OutcomeRecord

    record = OutcomeRecord.decode(source.block("outcome"))
    return Outcome(Detail(record.detail), record.text)


def _holders(source: Decoder) -> list[Holder]:
    from gecos_idl.object_types import Holder

    count = source.count(4, field="holders")
    return [Holder.decode(source.block("holders")) for _ in range(count)]
