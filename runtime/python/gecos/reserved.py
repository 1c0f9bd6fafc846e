"""What every object answers, whatever its interface: functions, so that nothing can clash."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from gecos.command import Command
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


def _call(robot: Object, code: int, name: str, result: Callable[[Decoder], T]) -> Command[T]:
    operation = Operation(code=code, name=name, access=Access.SENSOR)
    return Command(robot._gecos_session.reserved(code), Method[T, None](operation, result))


def _holders(source: Decoder) -> list[Holder]:
    from gecos_idl.object_types import Holder

    count = source.count(4, field="holders")
    return [Holder.decode(source.block("holders")) for _ in range(count)]
