"""Pairs old declarations with new declarations, and compares types by their encoding."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    ArrayType,
    Attribute,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Operation,
    Parameter,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Type,
    Typedef,
    Union,
)
from gidl.model.types import named_in
from gidl.rules.walk import slots
from gidl.wire.function_codes import hashed_name, member_name
from gidl.wire.wire_layout import node_of
from gidl.wire.wire_nodes import ArrayNode, MapNode, Node, ScalarNode, SequenceNode

Call = Operation | Attribute
Slot = Member | Parameter

_ELEMENTS = "the elements of "


@dataclass(frozen=True, slots=True)
class Sides:
    old: Model
    new: Model

    def declarations(self) -> Iterator[tuple[AnyDeclaration, AnyDeclaration | None]]:
        """Pairs each old declaration with the new one, or with None if the declaration was removed.
        Leaves out a removed declaration whose old file was only included by other files: perhaps
        the file is unchanged, and only the `#include` was removed."""
        became = {_key(self.new, d): d for d in self.new.declarations()}
        for file in self.old.files:
            for declaration in file.declarations:
                new = became.get(_key(self.old, declaration))
                if isinstance(declaration, AnnotationDeclaration):
                    continue
                if file.asked_for or new is not None:
                    yield declaration, new

    def calls(self, old: Interface, new: Interface) -> Iterator[tuple[Call, Call | None]]:
        """Pairs each member that `old` itself declares with the new member, or with None if the
        member was removed. Two members are a pair if their function codes and hashes are computed
        from the same name."""
        became = {member_name(self.new, m): m for m in new.members}
        for member in old.members:
            yield member, became.get(member_name(self.old, member))

    def same_type(self, old: Type | None, new: Type | None) -> bool:
        """Returns whether both types have the same encoding. For declared types, only the names are
        compared; `compare` in values.py compares the members of these types."""
        return wire_text(self.old, old) == wire_text(self.new, new)


def _key(model: Model, declaration: AnyDeclaration) -> str:
    return hashed_name(model, declaration.name, declaration.facts)


def wire_text(model: Model, used: Type | None) -> str:
    """Returns the text of a type, for messages and for the comparison of two types. Typedefs are
    resolved, and a renamed type has the name that its @hash_as keeps."""
    match used:
        case None:
            return "void"
        case PrimitiveType(kind):
            return kind.value
        case StringType(bound):
            return "string" if bound is None else f"string<{bound}>"
        case SequenceType(element, bound):
            inner = wire_text(model, element)
            return f"sequence<{inner}>" if bound is None else f"sequence<{inner}, {bound}>"
        case MapType(key, value, bound):
            inner = f"{wire_text(model, key)}, {wire_text(model, value)}"
            return f"map<{inner}>" if bound is None else f"map<{inner}, {bound}>"
        case ArrayType(element, dimensions):
            return wire_text(model, element) + "".join(f"[{d}]" for d in dimensions)
        case NamedType(name):
            declaration = model.find(name)
            if isinstance(declaration, Typedef):
                return wire_text(model, declaration.type)
            return _key(model, declaration)


def units(model: Model, used: Type) -> str:
    """Returns the units that typedefs and sequences inside a type declare, separated by commas."""
    match used:
        case SequenceType(element, _, unit):
            return f"{unit or ''},{units(model, element)}"
        case ArrayType(element=element):
            return units(model, element)
        case MapType(key, value):
            return f"{units(model, key)},{units(model, value)}"
        case NamedType(name):
            declaration = model.find(name)
            if isinstance(declaration, Typedef):
                return f"{declaration.unit or ''},{units(model, declaration.type)}"
    return ""


def ranges(model: Model, used: Type, limits: Range | None) -> dict[str, Range]:
    """Returns the ranges that limit the numbers in a value of type `used`, including the ranges
    that the typedefs of its elements, keys and values declare. Each key of the result names the
    numbers that the range limits: for example "the elements of ", or "" for the value itself."""
    return dict(_ranges(node_of(model, used, limits=limits), ""))


def _ranges(node: Node, part: str) -> Iterator[tuple[str, Range]]:
    match node:
        case ScalarNode(primitive, limits):
            # A floating-point number is compared with its range before the number is rounded for
            # sending: see `ScalarNode.bounds`.
            checked = limits if primitive.is_floating else node.bounds
            if checked is not None:
                yield part, checked
        case ArrayNode(element) | SequenceNode(element):
            yield from _ranges(element, f"{_ELEMENTS}{part.removeprefix(_ELEMENTS)}")
        case MapNode(key, value):
            yield from _ranges(key, f"the keys of {part}")
            yield from _ranges(value, f"the values of {part}")


def read_exactly(model: Model) -> dict[str, str]:
    """Returns the names of the enums whose unknown enumerators readers refuse in spite of a
    @default_literal. The value for each name is the reason. If the enum is the discriminator of a
    union, the reader cannot tell which arm follows. If the enum is the key of a map, two unknown
    keys would become the same key."""
    found: dict[str, str] = {}
    for slot in slots(model):
        for key in _keys(model, slot.type):
            found[key] = "the enum is the key of a map"
    for declaration in model.declarations():
        if isinstance(declaration, Union):
            tag = model.target(declaration.discriminator)
            if isinstance(tag, NamedType):
                found[tag.name] = f"the enum is the discriminator of union '{declaration.name}'"
    return found


def _keys(model: Model, used: Type) -> Iterator[str]:
    """Yields the declared types of the keys of all maps inside a type."""
    match used:
        case MapType(key, value):
            named = model.target(key)
            if isinstance(named, NamedType):
                yield named.name
            yield from _keys(model, value)
        case SequenceType(element=element) | ArrayType(element=element):
            yield from _keys(model, element)


def reached(model: Model, used: Type | None, into: set[str]) -> None:
    """Adds to `into` the names of all types that a value of type `used` may contain."""
    from gidl.lint.uses import declared_names

    work = list(named_in(used)) if used is not None else []
    while work:
        name = work.pop()
        if name not in into and model.has(name):
            into.add(name)
            work += declared_names(model, name)
