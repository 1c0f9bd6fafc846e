"""What a type and a value are called in C++."""

from __future__ import annotations

from dataclasses import dataclass

from gidl.languages import CPP_WORDS
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
    Range,
    SequenceType,
    StringType,
    Type,
    Typedef,
    Value,
    within,
)
from gidl.targets.cpp import names
from gidl.type_names import escaped
from gidl.wire_layout import Layout
from gidl.wire_nodes import (
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
    """A value with a place: a member, a parameter, a result. `label` is what messages call it."""

    expression: str
    label: str
    type: Type
    optional: bool = False
    range: Range | None = None


class Types:
    def __init__(self, model: Model, layout: Layout) -> None:
        self.model = model
        self.layout = layout
        self._checked: dict[str, bool] = {}

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
                return names.full_name(self.model, name)

    def parameter(self, used: Type, optional: bool = False) -> str:
        """How a function takes it: small ones as they are."""
        text = self.type(used, optional)
        target = self.model.target(used)
        small = isinstance(target, PrimitiveType)
        if isinstance(target, NamedType):
            small = isinstance(self.model.find(target.name), EnumDeclaration | Bitmask)
        return text if small and not optional else f"const {text}&"

    def literal(self, value: Value, used: Type) -> str:
        match value:
            case EnumValue(enum, literal):
                return f"{names.full_name(self.model, enum)}::{escaped(literal, CPP_WORDS)}"
            case bool():
                return "true" if value else "false"
            case str():
                target = self.model.target(used)
                is_char = target == PrimitiveType(Primitive.CHAR)
                return _quoted(value, "'" if is_char else '"')
            case _:
                return self._number(value, used)

    def _number(self, value: int | float, used: Type) -> str:
        target = self.model.target(used)
        kind = target.kind if isinstance(target, PrimitiveType) else Primitive.INT64
        if kind is Primitive.FLOAT:
            return f"{float(value)!r}F"
        if kind is Primitive.DOUBLE:
            return repr(float(value))
        if kind.is_unsigned:
            return f"{value}U"
        if value == -(1 << 63):
            return "std::numeric_limits<std::int64_t>::min()"
        return str(value)

    def initial(self, member: Member) -> str:
        """What stands behind a member's name: " = 1.0" or "{}".

        Never nothing: only so may a program name some members of a struct and leave the others out
        (`Trajectory{.speed = 0.5}`) under -Wextra.
        """
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
                enum = names.full_name(self.model, declaration.name)
                return f" = {enum}::{escaped(declaration.initial.name, CPP_WORDS)}"
        if isinstance(target, ArrayType):
            return self._initial_array(target)
        return "{}"

    def _initial_array(self, array: ArrayType) -> str:
        """Enumerators that are not 0 do not come by themselves."""
        element: Type = array
        while isinstance(element, ArrayType):
            element = self.model.target(element.element)
        if isinstance(element, NamedType):
            declaration = self.model.find(element.name)
            if isinstance(declaration, EnumDeclaration) and declaration.initial.number != 0:
                enum = names.full_name(self.model, declaration.name)
                word = escaped(declaration.initial.name, CPP_WORDS)
                return f" = gecos::wire::Everywhere{{{enum}::{word}}}"
        return "{}"

    def limits(self, slot: Slot) -> Range | None:
        """Bounds of a number, those of its typedefs included."""
        limits, used = slot.range, slot.type
        while isinstance(used, NamedType):
            declaration = self.model.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            limits, used = within(limits, declaration.range), declaration.type
        return limits


def range_test(x: str, kind: Primitive, limits: Range | None) -> str:
    """ "(x >= 0.01 && x <= 1.0)"; NaN is never inside. Empty where every value is."""
    if limits is None or not kind.is_number:
        return ""
    tests = []
    for sign, bound in ((">=", limits.minimum), ("<=", limits.maximum)):
        if bound is None:
            continue
        if kind.is_integer:
            least, most = kind.integer_limits
            if (sign == ">=" and bound <= least) or (sign == "<=" and bound >= most):
                continue
            text = f"{int(bound)}{'U' if kind.is_unsigned else ''}"
        else:
            text = f"{float(bound)!r}{'F' if kind is Primitive.FLOAT else ''}"
        tests.append(f"{x} {sign} {text}")
    return f"({' && '.join(tests)})" if tests else ""


def is_bulk(element: Node) -> bool:
    """Numbers that are swapped in bulk: every scalar but booleans."""
    return isinstance(element, ScalarNode) and element.primitive is not Primitive.BOOLEAN


_ESCAPES = {"\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t", "\0": "\\0"}


def _quoted(text: str, quote: str) -> str:
    out = ""
    for letter in text:
        if letter == quote:
            out += f"\\{quote}"
        elif letter in _ESCAPES:
            out += _ESCAPES[letter]
        elif " " <= letter <= "~":
            out += letter
        else:
            out += "".join(f"\\{byte:03o}" for byte in letter.encode("utf-8"))
    return f"{quote}{out}{quote}"
