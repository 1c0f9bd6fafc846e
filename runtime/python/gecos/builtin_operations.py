"""Built-in operations of every object. They are functions, so their names cannot clash."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from gecos.command import Command
from gecos.errors import Detail, State
from gecos.interface import Method
from gecos.proxy import Object
from gecos.wire import Decoder

if TYPE_CHECKING:
    from gecos_idl.object import GecosObject
    from gecos_idl.object_types import Description, Holder


def stop(robot: Object) -> Command[None]:
    """Stops the device, whoever moves it: ends leases, drops the queue, interrupts what runs."""
    return _answers_of(robot).stop()


def ping(robot: Object) -> Command[None]:
    """Finishes when the object's session has answered."""
    return _answers_of(robot).ping()


def describe(robot: Object) -> Command[Description]:
    """What the object is and what state it is in."""
    return _answers_of(robot).describe()


def holders(robot: Object) -> Command[list[Holder]]:
    """Who holds actor or master status."""
    return _answers_of(robot).holders()


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
    from gecos_idl.object import _GECOS_OBJECT_OUTCOME

    asked: Method[Any, None] = _GECOS_OBJECT_OUTCOME
    core = robot._gecos_session.outcome(command)

    def told(source: Decoder) -> Outcome:
        record = asked.result(source)
        return Outcome(Detail(record.detail), record.text)

    return Command(core, replace(asked, result=told))


def _answers_of(robot: Object) -> GecosObject:
    """The object as every object is."""
    from gecos_idl.object import GecosObject

    return GecosObject(robot._gecos_session)
