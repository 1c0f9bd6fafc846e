"""Finds the types that a type can contain. A type may contain itself; decoders limit how deep the
values of such a type may be nested."""

from __future__ import annotations

from collections.abc import Iterable

from gidl.model import (
    ArrayType,
    Bitset,
    MapType,
    Model,
    NamedType,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
)


def type_reaches(model: Model, start: str, goal: str) -> bool:
    """Returns whether a value of type `start` can contain a value of type `goal`."""
    open_names, seen = _direct(model, start), set[str]()
    while open_names:
        name = open_names.pop()
        if name == goal:
            return True
        if name not in seen:
            seen.add(name)
            open_names |= _direct(model, name)
    return False


def reached_types(model: Model, names: Iterable[str]) -> set[str]:
    """Returns the declarations in `names`, their bases, and all declarations that their values
    contain."""
    open_names, seen = set(names), set[str]()
    while open_names:
        name = open_names.pop()
        seen.add(name)
        declaration = model.find(name)
        found = _direct(model, name)
        if isinstance(declaration, Struct | Bitset) and declaration.base is not None:
            found.add(declaration.base)
        if isinstance(declaration, Union):
            found |= named_types(declaration.discriminator)
        open_names |= found - seen
    return seen


def _direct(model: Model, name: str) -> set[str]:
    declaration = model.find(name)
    match declaration:
        case Struct():
            used = [m.type for m in model.all_members(declaration)]
        case Union():
            used = [case.member.type for case in declaration.cases]
        case Typedef(type=target):
            used = [target]
        case _:
            used = []
    return {found for each in used for found in named_types(each)}


def named_types(used: Type) -> set[str]:
    """Returns the names of the declarations that a type mentions, for example "lab::Pose" for
    `sequence<lab::Pose>`. Typedefs are not resolved."""
    match used:
        case NamedType(name):
            return {name}
        case SequenceType(element) | ArrayType(element):
            return named_types(element)
        case MapType(key, value):
            return named_types(key) | named_types(value)
        case _:
            return set()
