"""Calls the members of a dynamic proxy by their names in the interface.

call(robot, "move", {"goal": {...}}).result()
read(robot, "tool").result()
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from gecos.dynamic_client.model import Attribute, Operation
from gecos.dynamic_client.names import METHOD_WORDS, escaped

if TYPE_CHECKING:
    from gecos.command import Command
    from gecos.dynamic_client.proxy import DynamicObject
    from gecos.stream import Stream


class UnknownMemberError(LookupError):
    """The interface has no operation or attribute with the given name."""


def operation(robot: DynamicObject, name: str) -> Operation:
    """Returns the description of an operation. Raises UnknownMemberError if there is no such
    operation."""
    for member in robot._gecos_model.members:
        if member.name == name and isinstance(member, Operation):
            return member
        if member.name == name and isinstance(member, Attribute) and member.event:
            raise UnknownMemberError(_why_unreadable(robot, member))
    known = (m.name for m in robot._gecos_model.members if isinstance(m, Operation))
    raise _unknown(robot, "operation", name, list(dict.fromkeys(known)))


def attribute(robot: DynamicObject, name: str) -> Attribute:
    """Returns the description of an attribute. Raises UnknownMemberError if there is no such
    attribute."""
    for member in robot._gecos_model.members:
        if member.name == name and isinstance(member, Attribute):
            if member.can_be_read:
                return member
            raise UnknownMemberError(_why_unreadable(robot, member))
    raise _unknown(robot, "attribute", name, _names(robot, lambda m: m.can_be_read))


def attribute_or_event(robot: DynamicObject, name: str) -> Attribute:
    """Returns the description of an event, or of an attribute whose value can be read. Raises
    UnknownMemberError if there is no such member."""
    for member in robot._gecos_model.members:
        if member.name == name and isinstance(member, Attribute):
            return member if member.event else attribute(robot, name)
    known = _names(robot, lambda m: m.can_be_read or m.can_be_watched)
    raise _unknown(robot, "attribute or event", name, known)


def _why_unreadable(robot: DynamicObject, member: Attribute) -> str:
    where = f"{robot._gecos_session.object_name}.{member.name}"
    called = f"robot.{escaped(member.name, METHOD_WORDS)}"
    if member.event:
        return (
            f"{where} is an event, which can neither be called nor read or set; watch it, or in a "
            f"program subscribe with `{called}.stream()`"
        )
    return (
        f"{where} is an inward stream: clients send its samples and nobody can read, set or watch "
        f"it; in a program, send with `{called}.writer()`"
    )


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
    """Subscribes to an event or to the stream of an attribute. Raises UnknownMemberError if there
    is no such stream."""
    if attribute_or_event(robot, name).stream is None:
        raise _unknown(robot, "stream", name, _names(robot, lambda m: m.can_be_watched))
    opened: Stream[Any] = _member(robot, name).stream()
    return opened


def _member(robot: DynamicObject, name: str) -> Any:
    return getattr(robot, escaped(name, METHOD_WORDS))


def _names(robot: DynamicObject, wanted: Callable[[Attribute], bool]) -> list[str]:
    """Returns the names of the attributes and events for which `wanted` is true."""
    members = robot._gecos_model.members
    found = (m.name for m in members if isinstance(m, Attribute) and wanted(m))
    return list(dict.fromkeys(found))


def _unknown(robot: DynamicObject, kind: str, name: str, known: list[str]) -> UnknownMemberError:
    from difflib import get_close_matches

    near = get_close_matches(name, known, n=1)
    instead = f"did you mean {near[0]}?" if near else f"it has {', '.join(known) or 'none'}"
    session = robot._gecos_session
    return UnknownMemberError(
        f"{session.object_name} ({session.interface_name}) has no {kind} {name!r}; {instead}"
    )
