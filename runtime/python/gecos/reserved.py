"""Built-in operations of every object. They are functions, so their names cannot clash."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from gecos.command import Command
from gecos.errors import Detail, State
from gecos.interface import Access, Method, Operation, method, nothing
from gecos.proxy import Object
from gecos.wire import Decoder, layout

if TYPE_CHECKING:
    from gecos_idl.object_types import Description, Holder

_STOP = Method[None, None](Operation(2, "stop", Access.SENSOR), nothing)
_PING = Method[None, None](Operation(3, "ping", Access.SENSOR), nothing)


def stop(robot: Object) -> Command[None]:
    """Stops the device for every holder: ends leases, drops the queue, interrupts commands."""
    return _call(robot, _STOP)


def ping(robot: Object) -> Command[None]:
    """Finishes when the object's session has answered."""
    return _call(robot, _PING)


def describe(robot: Object) -> Command[Description]:
    """Description and present state of the object."""
    from gecos_idl.object_types import Description

    return _call(robot, method(Operation(4, "describe", Access.SENSOR), gives=Description))


def holders(robot: Object) -> Command[list[Holder]]:
    """The holders of actor or master status."""
    from gecos_idl.object_types import Holder

    listed = layout.items(Holder)
    return _call(robot, method(Operation(1, "holders", Access.SENSOR), gives=listed))


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a command, or its present state."""

    detail: Detail
    text: str  # why, when it is not DONE

    @property
    def state(self) -> State:
        return self.detail.state


def outcome(robot: Object, command: str) -> Command[Outcome]:
    """The outcome of the actor command with this id that ended as OUTCOME_UNKNOWN here.

    Asked through a new proxy; the state of the command itself never changes. NOT_STARTED is a
    promise: what has not arrived by now never starts. SENT: it has not arrived and may still start;
    ask again. OUTCOME_UNKNOWN: the server was started anew
    since, or keeps it no more (it keeps the last 1024 of each object). Raises ValueError for what
    is no id.
    """
    from gecos_idl.object_types import OutcomeRecord

    asked = method(Operation(9, "outcome", Access.SENSOR), gives=OutcomeRecord)
    core = robot._gecos_session.outcome(command)

    def told(source: Decoder) -> Outcome:
        record = asked.result(source)
        return Outcome(Detail(record.detail), record.text)

    return Command(core, replace(asked, result=told))


def _call(robot: Object, method: Method[Any, Any]) -> Command[Any]:
    return Command(robot._gecos_session.reserved(method.operation.code), method)
