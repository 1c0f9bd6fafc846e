"""How the names of an interface are written in C++."""

from __future__ import annotations

from gidl.languages import CPP_STRUCT_WORDS, CPP_TYPES, CPP_WORDS
from gidl.model import Interface, Model, Struct
from gidl.type_names import escaped

OBJECT_REF = "gecos::ObjectRef"
"""What a value of an interface's type is, and where that is declared."""
OBJECT_REF_STEM = "gecos/object_ref"


def scope_of(model: Model, scoped_name: str) -> tuple[str, ...]:
    """Modules around a declaration. An interface around a type is part of its name instead."""
    parts = scoped_name.split("::")[:-1]
    while parts and model.has("::".join(parts)):
        parts.pop()
    return tuple(escaped(part, CPP_WORDS) for part in parts)


def simple_name(model: Model, scoped_name: str) -> str:
    """`robcl::Manipulator::Mode` is called `Manipulator_Mode`: classes cannot be reopened."""
    parts = scoped_name.split("::")
    modules = len(scope_of(model, scoped_name))
    return escaped("_".join(parts[modules:]), CPP_TYPES.type_words)


def full_name(model: Model, scoped_name: str) -> str:
    """As C++ writes it from anywhere; a hand-written type where the struct maps to one,
    a reference where an interface is used as a type."""
    declaration = model.find(scoped_name)
    if isinstance(declaration, Struct) and declaration.maps_to and declaration.maps_to.cpp:
        return declaration.maps_to.cpp[0]
    if isinstance(declaration, Interface):
        return OBJECT_REF
    return full_name_of(model, scoped_name)


def full_name_of(model: Model, scoped_name: str) -> str:
    return "::".join((*scope_of(model, scoped_name), simple_name(model, scoped_name)))


def member_name(name: str) -> str:
    return escaped(name, CPP_STRUCT_WORDS)


def method_names(model: Model, interface: Interface) -> set[str]:
    """Every name that the operations and attributes of an interface bring to its class."""
    return {escaped(m.name, CPP_WORDS) for m in model.all_interface_members(interface)}
