"""How the names of an interface are written in C++."""

from __future__ import annotations

from gidl.keywords import CPP, words
from gidl.model import Interface, Model, Struct
from gidl.targets.naming import escaped

_MACROS = words(
    """
    assert errno stdin stdout stderr offsetof alloca NULL TRUE FALSE DOMAIN EOF NAN INFINITY
    HUGE_VAL BIG_ENDIAN LITTLE_ENDIAN BYTE_ORDER
    """
)
KEYWORDS = CPP | {"std", "tl"} | _MACROS
"""Keywords, the namespaces that generated code names, and the macros that headers bring along."""

OBJECT_REF = "gecos::ObjectRef"
"""What a value of an interface's type is, and where that is declared."""
OBJECT_REF_STEM = "gecos/object_ref"

# Members that every generated struct has besides its own.
STRUCT_WORDS = KEYWORDS | {"encoded_size", "encode", "decode", "fingerprint", "type_name"}

UNION_WORDS = STRUCT_WORDS | {"tag", "value", "Held"}
BITSET_WORDS = STRUCT_WORDS | {"bits", "set_bits", "raw"}

# What a type must not be called: the functions beside types, the members, and what the bodies of
# both call their parameters and locals. Each would hide it.
TYPE_WORDS = (
    UNION_WORDS
    | BITSET_WORDS
    | words(
        """
        a arm b call code core decode_enum entry field flags from guard has item key main names
        number out read result row run selecting separator session size stamp_ns to to_string why
        wrong
        """
    )
)


def scope_of(model: Model, scoped_name: str) -> tuple[str, ...]:
    """Modules around a declaration. An interface around a type is part of its name instead."""
    parts = scoped_name.split("::")[:-1]
    while parts and model.has("::".join(parts)):
        parts.pop()
    return tuple(escaped(part, KEYWORDS) for part in parts)


def simple_name(model: Model, scoped_name: str) -> str:
    """`robcl::Manipulator::Mode` is called `Manipulator_Mode`: classes cannot be reopened."""
    parts = scoped_name.split("::")
    modules = len(scope_of(model, scoped_name))
    return escaped("_".join(parts[modules:]), TYPE_WORDS)


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
    return escaped(name, STRUCT_WORDS)


def method_names(model: Model, interface: Interface) -> set[str]:
    """Every name that the operations and attributes of an interface bring to its class."""
    return {escaped(m.name, KEYWORDS) for m in model.all_interface_members(interface)}
