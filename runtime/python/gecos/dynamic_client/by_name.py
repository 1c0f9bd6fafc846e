"""Calls the members of a dynamic proxy by their names in the interface.

call(robot, "move", {"goal": {...}}).result()
read(robot, "tool").result()
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from gecos.dynamic_client.model import Attribute, Operation
from gecos.dynamic_client.names import METHOD_WORDS, escaped

if TYPE_CHECKING:
    from gecos.command import Command
    from gecos.dynamic_client.proxy import DynamicObject
    from gecos.stream import Stream


class UnknownMemberError(LookupError):
    """The interface has no such operation or attribute."""


def operation(robot: DynamicObject, name: str) -> Operation:
    """Returns the description of an operation. Raises UnknownMemberError if there is no such
    operation."""
    for member in robot._gecos_model.members:
        if member.name == name and isinstance(member, Operation) and member.offered:
            return member
    raise _unknown(robot, "operation", name, _names(robot, Operation))


def attribute(robot: DynamicObject, name: str) -> Attribute:
    """Returns the description of an attribute. Raises UnknownMemberError if there is no such
    attribute."""
    for member in robot._gecos_model.members:
        if member.name == name and isinstance(member, Attribute) and member.offered:
            return member
        if member.name == name and isinstance(member, Attribute):
            raise UnknownMemberError(
                f"{robot._gecos_session.object_name}.{name} is an inward stream: clients send its"
                " samples and nobody can read, set or watch it; in a program, send with"
                f" `robot.{escaped(name, METHOD_WORDS)}.writer()`"
            )
    raise _unknown(robot, "attribute", name, _names(robot, Attribute))


def call(robot: DynamicObject, name: str, arguments: Mapping[str, Any]) -> Command[Any, Any]:
    """Calls an operation. Raises TypeError or EncodeError if the arguments do not fit."""
    called: Command[Any, Any] = _member(robot, operation(robot, name).name)(**arguments)
    return called


def read(robot: DynamicObject, name: str) -> Command[Any, None]:
    """Reads an attribute once."""
    asked: Command[Any, None] = _member(robot, attribute(robot, name).name)()
    return asked


def write(robot: DynamicObject, name: str, value: Any) -> Command[None, None]:
    """Sets an attribute. Raises UnknownMemberError if the attribute is read-only."""
    if not attribute(robot, name).can_be_set:
        where = f"{robot._gecos_session.object_name}.{name}"
        raise UnknownMemberError(f"{where} is readonly and cannot be set")
    written: Command[None, None] = getattr(robot, f"set_{name}")(value)
    return written


def subscribe(robot: DynamicObject, name: str) -> Stream[Any]:
    """Opens the stream of an attribute. Raises UnknownMemberError if the attribute has no
    stream."""
    if attribute(robot, name).stream is None:
        streams = [n for n in _names(robot, Attribute) if attribute(robot, n).stream is not None]
        raise _unknown(robot, "stream", name, streams)
    opened: Stream[Any] = _member(robot, name).stream()
    return opened


def _member(robot: DynamicObject, name: str) -> Any:
    return getattr(robot, escaped(name, METHOD_WORDS))


def _names(robot: DynamicObject, kind: type[Operation] | type[Attribute]) -> list[str]:
    members = robot._gecos_model.members
    return list(dict.fromkeys(m.name for m in members if isinstance(m, kind) and m.offered))


def _unknown(robot: DynamicObject, kind: str, name: str, known: list[str]) -> UnknownMemberError:
    from difflib import get_close_matches

    near = get_close_matches(name, known, n=1)
    instead = f"did you mean {near[0]}?" if near else f"it has {', '.join(known) or 'none'}"
    session = robot._gecos_session
    return UnknownMemberError(
        f"{session.object_name} ({session.interface_name}) has no {kind} {name!r}; {instead}"
    )
