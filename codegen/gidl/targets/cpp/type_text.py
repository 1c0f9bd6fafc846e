"""C++ text for types, literals and initialisers."""

from __future__ import annotations

from dataclasses import dataclass

from gidl.model import (
    ArrayType,
    Bitmask,
    EnumDeclaration,
    EnumValue,
    MapType,
    Member,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
    Value,
)
from gidl.names.languages import CPP_WORDS
from gidl.names.type_names import escaped
from gidl.targets.cpp import names
from gidl.targets.cpp.ranges import number_text
from gidl.wire.wire_layout import Layout
from gidl.wire.wire_nodes import (
    Node,
    ScalarNode,
)

PRIMITIVES = {
    Primitive.BOOLEAN: "bool", Primitive.OCTET: "std::uint8_t", Primitive.CHAR: "char",
    Primitive.INT8: "std::int8_t", Primitive.UINT8: "std::uint8_t",
    Primitive.INT16: "std::int16_t", Primitive.UINT16: "std::uint16_t",
    Primitive.INT32: "std::int32_t", Primitive.UINT32: "std::uint32_t",
    Primitive.INT64: "std::int64_t", Primitive.UINT64: "std::uint64_t",
    Primitive.FLOAT: "float", Primitive.DOUBLE: "double",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Slot:
    """A member, a parameter or a result. `label` is its name in error messages."""

    expression: str
    label: str
    node: Node
    bulk: bool = False  # a @bulk sequence of octets, which may be written and read in place


class Types:
    def __init__(self, model: Model, layout: Layout) -> None:
        self.model = model
        self.layout = layout

    def named(self, scoped_name: str) -> str:
        """The absolute name of the C++ type of a declared type."""
        return names.type_name(self.model, self.layout, scoped_name)

    def function(self, scoped_name: str, function: str) -> str:
        """The name of `function` in the namespace of a declared type, for example
        `::robcl::decode_enum`."""
        return names.function_name(self.model, self.layout, scoped_name, function)

    def type(self, used: Type, optional: bool = False) -> str:
        if optional:
            return f"std::optional<{self.type(used)}>"
        match used:
            case PrimitiveType(kind):
                return PRIMITIVES[kind]
            case StringType():
                return "std::string"
            case SequenceType(element):
                return f"std::vector<{self.type(element)}>"
            case MapType(key, value):
                order = ""
                if self.model.target(key) == PrimitiveType(Primitive.CHAR):
                    order = ", gecos::wire::LatinOrder"
                return f"std::map<{self.type(key)}, {self.type(value)}{order}>"
            case ArrayType(element, dimensions):
                text = self.type(element)
                for size in reversed(dimensions):
                    text = f"std::array<{text}, {size}>"
                return text
            case NamedType(name):
                return self.named(name)

    def parameter(self, used: Type, optional: bool = False) -> str:
        """Returns the type of a parameter: small values are passed by value, other values by const
        reference."""
        text = self.type(used, optional)
        target = self.model.target(used)
        small = isinstance(target, PrimitiveType)
        if isinstance(target, NamedType):
            small = isinstance(self.model.find(target.name), EnumDeclaration | Bitmask)
        return text if small and not optional else f"const {text}&"

    def literal(self, value: Value, used: Type) -> str:
        match value:
            case EnumValue(enum, literal):
                return self._enumerators(enum, literal)
            case bool():
                return "true" if value else "false"
            case str():
                target = self.model.target(used)
                is_char = target == PrimitiveType(Primitive.CHAR)
                return _quoted(value, "'" if is_char else '"')
            case _:
                return self._number(value, used)

    def _enumerators(self, enum: str, literal: str) -> str:
        """The C++ text of an enumerator, or of the flags of a bitmask (`literal` is
        "LEFT|RIGHT")."""
        words = [escaped(word.strip(), CPP_WORDS) for word in literal.split("|")]
        return " | ".join(f"{self.named(enum)}::{word}" for word in words)

    def _number(self, value: int | float, used: Type) -> str:
        target = self.model.target(used)
        kind = target.kind if isinstance(target, PrimitiveType) else Primitive.INT64
        return number_text(value, kind)

    def initial(self, member: Member) -> str:
        """The initialiser after a member's name: " = 1.0" or "{}". The initialiser is never empty,
        so that a program may initialise only some members of a struct (`Trajectory{.speed = 0.5}`)
        without a warning by -Wextra."""
        if member.optional:
            return "{}"
        if member.default is not None:
            return f" = {self.literal(member.default, member.type)}"
        target = self.model.target(member.type)
        if isinstance(target, PrimitiveType):
            zero = {Primitive.BOOLEAN: "false", Primitive.CHAR: "'\\0'"}.get(target.kind, "0")
            return f" = {zero}"
        if isinstance(target, NamedType):
            declaration = self.model.find(target.name)
            if isinstance(declaration, EnumDeclaration):
                enum = self.named(declaration.name)
                return f" = {enum}::{escaped(declaration.initial.name, CPP_WORDS)}"
        if isinstance(target, ArrayType):
            return self._initial_array(target)
        return "{}"

    def _initial_array(self, array: ArrayType) -> str:
        """Returns the initialiser of an array. The initialiser `{}` would set all elements to 0. An
        array of enums therefore has another initialiser if the number of the default enumerator is
        not 0."""
        element: Type = array
        while isinstance(element, ArrayType):
            element = self.model.target(element.element)
        if isinstance(element, NamedType):
            declaration = self.model.find(element.name)
            if isinstance(declaration, EnumDeclaration) and declaration.initial.number != 0:
                enum = self.named(declaration.name)
                word = escaped(declaration.initial.name, CPP_WORDS)
                return f" = gecos::wire::Everywhere{{{enum}::{word}}}"
        return "{}"


def is_bulk(element: Node) -> bool:
    """Returns whether an array of such elements is byte-swapped in one pass. This is the case for
    all scalars except booleans."""
    return isinstance(element, ScalarNode) and element.primitive is not Primitive.BOOLEAN


_ESCAPES = {"\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t", "\0": "\\0"}


def _quoted(text: str, quote: str) -> str:
    """Returns a C++ literal that begins and ends with the character `quote`. A char is one byte of
    Latin-1, and a string is UTF-8."""
    out = ""
    for letter in text:
        if letter == quote or (letter == "?" and out.endswith("?")):  # avoids a trigraph
            out += f"\\{letter}"
        elif letter in _ESCAPES:
            out += _ESCAPES[letter]
        elif " " <= letter <= "~":
            out += letter
        else:
            encoding = "latin-1" if quote == "'" else "utf-8"
            out += "".join(f"\\{byte:03o}" for byte in letter.encode(encoding))
    return f"{quote}{out}{quote}"
