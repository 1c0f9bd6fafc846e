"""C++ names of declarations, from the table of names in the layout.

Names of types are absolute, `::robcl::Frame`, so that no name in an enclosing scope can hide them.
"""

from __future__ import annotations

from gidl.model import AnyDeclaration, Interface, Model, Struct
from gidl.names.languages import CPP_METHOD_WORDS, CPP_PARAMETER_WORDS, CPP_STRUCT_WORDS
from gidl.names.type_names import TypeName, escaped
from gidl.targets.naming import LocalNames
from gidl.wire.wire_layout import Layout

OBJECT_REF = "::gecos::ObjectRef"
"""The C++ type of a value whose declared type is an interface."""
OBJECT_REF_STEM = "gecos/object_ref"


class Locals(LocalNames):
    """Chooses unique names for the variables in a function body. A name that is already taken gets
    an underscore at its start. No name in an interface begins with an underscore, so the variable
    hides nothing. A variable with an underscore at its end could hide a constant: `item_` may be
    the C++ name of a constant `item`."""

    def fresh(self, wanted: str) -> str:
        name, number = wanted, 1
        while name in self._taken:
            name = f"_{wanted}{'' if number == 1 else number}"
            number += 1
        self._taken.add(name)
        return name


def absolute(place: TypeName) -> str:
    return "::" + "::".join((*place.scope, place.name))


def hand_written(declaration: AnyDeclaration) -> tuple[str, str] | None:
    """Returns the name and the header of the hand-written C++ type that a declaration maps to, or
    None."""
    maps_to = declaration.maps_to if isinstance(declaration, Struct) else None
    return maps_to.cpp if maps_to is not None else None


def type_name(model: Model, layout: Layout, scoped_name: str) -> str:
    """The C++ type of a value: the hand-written type that a struct maps to, ObjectRef for an
    interface, else the generated type."""
    declaration = model.find(scoped_name)
    by_hand = hand_written(declaration)
    if by_hand is not None:
        return f"::{by_hand[0]}"
    if isinstance(declaration, Interface):
        return OBJECT_REF
    return absolute(layout.cpp_names.types[scoped_name])


def function_name(model: Model, layout: Layout, scoped_name: str, function: str) -> str:
    """The name of `function` in the namespace of a value's type, for example
    `::robcl::decode_enum`."""
    return f"{type_name(model, layout, scoped_name).rpartition('::')[0]}::{function}"


def member_name(name: str) -> str:
    return escaped(name, CPP_STRUCT_WORDS)


def method_name(name: str) -> str:
    """Returns the C++ name of an operation or an attribute, as it is in the proxy and the servant
    of its interface."""
    return escaped(name, CPP_METHOD_WORDS)


def parameter_name(layout: Layout, interface: Interface, name: str) -> str:
    """Returns the name of a parameter in the methods of its interface. Underscores are added at its
    end until the name hides no other name. Parameters whose names differ only in underscores at
    their ends (`speed`, `speed_`) get different names."""
    hidden = layout.cpp_names.hidden[interface.name]
    plain = name.rstrip("_")
    taken, underscores = "", -1
    for as_written in range(len(name) - len(plain) + 1):
        underscores = max(underscores + 1, as_written)
        while (taken := plain + "_" * underscores) in hidden or taken in CPP_PARAMETER_WORDS:
            underscores += 1
    return taken


def method_names(model: Model, interface: Interface) -> set[str]:
    """The C++ names of all operations and attributes of an interface, also inherited ones."""
    return {method_name(m.name) for m in model.all_interface_members(interface)}
