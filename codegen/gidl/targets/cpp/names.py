"""How the names of declarations are written in C++.

The table of the layout decides them. Types are named absolutely, `::robcl::Frame`, so that nothing
around the place where a name stands can give it another meaning.
"""

from __future__ import annotations

from gidl.languages import CPP_STRUCT_WORDS, CPP_WORDS
from gidl.model import AnyDeclaration, Interface, Model, Struct
from gidl.type_names import TypeName, escaped
from gidl.wire_layout import Layout

OBJECT_REF = "::gecos::ObjectRef"
"""The type of a value whose declared type is an interface, and the header of that type."""
OBJECT_REF_STEM = "gecos/object_ref"


def absolute(place: TypeName) -> str:
    return "::" + "::".join((*place.scope, place.name))


def hand_written(declaration: AnyDeclaration) -> tuple[str, str] | None:
    """Type and header, where the declaration maps to a type that is written by hand."""
    maps_to = declaration.maps_to if isinstance(declaration, Struct) else None
    return maps_to.cpp if maps_to is not None else None


def type_name(model: Model, layout: Layout, scoped_name: str) -> str:
    """The type of a value: a hand-written one where the struct maps to one, a reference where an
    interface is used as a type."""
    declaration = model.find(scoped_name)
    by_hand = hand_written(declaration)
    if by_hand is not None:
        return f"::{by_hand[0]}"
    if isinstance(declaration, Interface):
        return OBJECT_REF
    return absolute(layout.cpp_names.types[scoped_name])


def function_name(model: Model, layout: Layout, scoped_name: str, function: str) -> str:
    """A function that stands beside the type of a value: `::robcl::decode_enum`."""
    return f"{type_name(model, layout, scoped_name).rpartition('::')[0]}::{function}"


def member_name(name: str) -> str:
    return escaped(name, CPP_STRUCT_WORDS)


def method_names(model: Model, interface: Interface) -> set[str]:
    """Every name that the operations and attributes of an interface bring to its class."""
    return {escaped(m.name, CPP_WORDS) for m in model.all_interface_members(interface)}
