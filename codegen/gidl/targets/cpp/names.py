"""How the names of an interface are written in C++."""

from __future__ import annotations

from gidl.model import Interface, Model, Struct
from gidl.targets.naming import escaped

KEYWORDS = frozenset(
    [
        "alignas",
        "alignof",
        "and",
        "and_eq",
        "asm",
        "auto",
        "bitand",
        "bitor",
        "bool",
        "break",
        "case",
        "catch",
        "char",
        "char8_t",
        "char16_t",
        "char32_t",
        "class",
        "compl",
        "concept",
        "const",
        "consteval",
        "constexpr",
        "constinit",
        "const_cast",
        "continue",
        "co_await",
        "co_return",
        "co_yield",
        "decltype",
        "default",
        "delete",
        "do",
        "double",
        "dynamic_cast",
        "else",
        "enum",
        "explicit",
        "export",
        "extern",
        "false",
        "float",
        "for",
        "friend",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "mutable",
        "namespace",
        "new",
        "noexcept",
        "not",
        "not_eq",
        "nullptr",
        "operator",
        "or",
        "or_eq",
        "private",
        "protected",
        "public",
        "register",
        "reinterpret_cast",
        "requires",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "static_assert",
        "static_cast",
        "struct",
        "switch",
        "template",
        "this",
        "thread_local",
        "throw",
        "true",
        "try",
        "typedef",
        "typeid",
        "typename",
        "union",
        "unsigned",
        "using",
        "virtual",
        "void",
        "volatile",
        "wchar_t",
        "while",
        "xor",
        "xor_eq",
        "std",
        "tl",
        "NULL",
        "TRUE",
        "FALSE",
        "DOMAIN",
        "EOF",
    ]
)
"""Keywords, the namespaces that generated code names, and the macros that headers bring along."""

# Members that every generated struct has besides its own.
STRUCT_WORDS = KEYWORDS | {"encoded_size", "encode", "decode", "fingerprint", "type_name"}


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
    return escaped("_".join(parts[modules:]), KEYWORDS)


def full_name(model: Model, scoped_name: str) -> str:
    """As C++ writes it from anywhere; a hand-written type where the struct maps to one."""
    declaration = model.find(scoped_name)
    if isinstance(declaration, Struct) and declaration.maps_to and declaration.maps_to.cpp:
        return declaration.maps_to.cpp[0]
    return full_name_of(model, scoped_name)


def full_name_of(model: Model, scoped_name: str) -> str:
    return "::".join((*scope_of(model, scoped_name), simple_name(model, scoped_name)))


def member_name(name: str) -> str:
    return escaped(name, STRUCT_WORDS)


def method_names(model: Model, interface: Interface) -> set[str]:
    """Every name that the operations and attributes of an interface bring to its class."""
    return {escaped(m.name, KEYWORDS) for m in model.all_interface_members(interface)}
