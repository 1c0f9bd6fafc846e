"""Finds the octets of a stream's samples that are written and read in place."""

from __future__ import annotations

from gidl.model.declarations import ExceptionStruct, Member, Struct, Typedef, Union
from gidl.model.files import Model
from gidl.model.interfaces import Attribute
from gidl.model.types import (
    ArrayType,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    Type,
)


def stream_in_place(model: Model, attribute: Attribute) -> Member | None:
    """Returns the member whose octets are written and read in place in the samples that an
    attribute publishes. Returns None if the samples have no such member, or if the attribute
    publishes no samples."""
    if not attribute.streams_out or attribute.optional or attribute.event is not None:
        return None
    return _octets_in_place(model, attribute.type)


def _octets_in_place(model: Model, used: Type) -> Member | None:
    """Returns the member whose octets are written and read in place, if `used` is the type of a
    stream's samples. This member is a `sequence<octet>` of the struct itself, and the only @bulk
    member that a sample can contain. Returns None if the type has no such member."""
    target = model.target(used)
    struct = model.find(target.name) if isinstance(target, NamedType) else None
    if not isinstance(struct, Struct) or isinstance(struct, ExceptionStruct):
        return None
    members = model.all_members(struct)
    found = [m for m in members if m.bulk]
    if struct.maps_to is not None or len(found) != 1 or not are_octets(model, found[0]):
        return None
    others = [m.type for m in members if m is not found[0]]
    return None if _have_bulk(model, others, set()) else found[0]


def are_octets(model: Model, member: Member) -> bool:
    """Returns whether a @bulk member is a `sequence<octet>` whose octets may have any value."""
    target = model.target(member.type)
    return (
        isinstance(target, SequenceType)
        and model.target(target.element) == PrimitiveType(Primitive.OCTET)
        and not member.optional
        and member.range is None
        and not _is_ranged(model, member.type)
        and not _is_ranged(model, target.element)
    )


def _is_ranged(model: Model, used: Type) -> bool:
    while isinstance(used, NamedType):
        typedef = model.find(used.name)
        if not isinstance(typedef, Typedef):
            return False
        if typedef.range is not None:
            return True
        used = typedef.type
    return False


def _have_bulk(model: Model, types: list[Type], seen: set[str]) -> bool:
    """Returns whether a value of one of `types` can contain a @bulk member."""
    open_types = list(types)
    while open_types:
        match model.target(open_types.pop()):
            case SequenceType(element) | ArrayType(element):
                open_types.append(element)
            case MapType(key, value):
                open_types += [key, value]
            case NamedType(name) if name not in seen:
                seen.add(name)
                members = _members(model, name)
                if any(m.bulk for m in members):
                    return True
                open_types += [m.type for m in members]
    return False


def _members(model: Model, name: str) -> tuple[Member, ...]:
    match model.find(name):
        case Struct() as struct:
            return model.all_members(struct)
        case Union(cases=cases):
            return tuple(case.member for case in cases)
        case _:
            return ()
