"""What a type is hinted as, and what values are written as."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gidl.model import (
    ArrayType,
    Bitmask,
    EnumDeclaration,
    EnumValue,
    ExceptionStruct,
    MapType,
    Member,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Value,
    within,
)
from gidl.targets.python import names
from gidl.wire_layout import Layout, node_of
from gidl.wire_nodes import (
    Node,
    ScalarNode,
)

CODES = {
    Primitive.BOOLEAN: "?", Primitive.OCTET: "B", Primitive.CHAR: "B", Primitive.INT8: "b",
    Primitive.UINT8: "B", Primitive.INT16: "h", Primitive.UINT16: "H", Primitive.INT32: "i",
    Primitive.UINT32: "I", Primitive.INT64: "q", Primitive.UINT64: "Q", Primitive.FLOAT: "f",
    Primitive.DOUBLE: "d",
}  # fmt: skip
DTYPES = {
    "?": "bool_", "b": "int8", "B": "uint8", "h": "int16", "H": "uint16", "i": "int32",
    "I": "uint32", "q": "int64", "Q": "uint64", "f": "float32", "d": "float64",
}  # fmt: skip
SIZES = {"?": 1, "b": 1, "B": 1, "h": 2, "H": 2, "i": 4, "I": 4, "q": 8, "Q": 8, "f": 4, "d": 8}


@dataclass(frozen=True, slots=True)
class Slot:
    """A value with a place; `label` is what messages call it."""

    expression: str
    label: str
    type: Type
    optional: bool = False
    range: Range | None = None


class Types:
    def __init__(self, model: Model, layout: Layout) -> None:
        self.model = model
        self.layout = layout

    def hint(self, used: Type, optional: bool = False) -> str:
        if optional:
            return f"{self.hint(used)} | None"
        match used:
            case PrimitiveType(Primitive.BOOLEAN):
                return "bool"
            case PrimitiveType(Primitive.CHAR) | StringType():
                return "str"
            case PrimitiveType(kind):
                return "float" if kind.is_floating else "int"
            case SequenceType(element) | ArrayType(element):
                node = node_of(self.model, element)
                depth = len(used.dimensions) if isinstance(used, ArrayType) else 1
                if is_octet(node) and depth == 1:
                    return "bytes"
                code = self.bulk_code(node)
                if code is not None:
                    return f"_npt.NDArray[_np.{DTYPES[code]}]"
                text = self.hint(element)
                for _ in range(depth):
                    text = f"list[{text}]"
                return text
            case MapType(key, value):
                return f"dict[{self.hint(key)}, {self.hint(value)}]"
            case NamedType(name):
                declaration = self.model.find(name)
                if isinstance(declaration, Typedef):
                    return self.hint(declaration.type)
                return names.value_name(self.model, name)
        raise AssertionError(used)

    def words(self, struct: Struct) -> frozenset[str]:
        """What its members cannot be called: also not like a type in the hints beside them."""
        words = names.STRUCT_WORDS
        if isinstance(struct, ExceptionStruct):
            words = names.EXCEPTION_WORDS
        hints = " ".join(self.hint(m.type) for m in self.model.all_members(struct))
        return words | set(re.findall(r"(?<![.\w])[A-Za-z]\w*", hints))

    def holds_array(self, used: Type) -> bool:
        """Whether `==` needs help: arrays compare element by element."""
        return "_npt.NDArray" in self.hint(used)

    def literal(self, value: Value, used: Type) -> str:
        match value:
            case EnumValue(enum, literal):
                return f"{names.type_name(self.model, enum)}.{names.enumerator(literal)}"
            case bool() | str():
                return quoted(value) if isinstance(value, str) else str(value)
            case _:
                target = self.model.target(used)
                floating = isinstance(target, PrimitiveType) and target.kind.is_floating
                return repr(float(value)) if floating else str(value)

    def initial(self, member: Member) -> tuple[str, bool]:
        """Default expression, and whether it has to be made anew for each value."""
        if member.optional:
            return "None", False
        if member.default is not None:
            return self.literal(member.default, member.type), False
        return self._zero(member.type)

    def _zero(self, used: Type) -> tuple[str, bool]:
        target = self.model.target(used)
        match target:
            case PrimitiveType(Primitive.BOOLEAN):
                return "False", False
            case PrimitiveType(Primitive.CHAR):
                return '"\\0"', False
            case PrimitiveType(kind):
                return ("0.0" if kind.is_floating else "0"), False
            case StringType():
                return '""', False
            case MapType():
                return "dict", True
            case SequenceType(element):
                node = node_of(self.model, element)
                if is_octet(node):
                    return 'b""', False
                code = self.bulk_code(node)
                return (f'lambda: _wire.zeros("{code}", 0)' if code else "list"), True
            case ArrayType(element, dimensions):
                return self._zero_array(element, dimensions)
            case NamedType(name):
                declaration = self.model.find(name)
                mine = names.value_name(self.model, name)
                if isinstance(declaration, EnumDeclaration):
                    return f"{mine}.{names.enumerator(declaration.initial.name)}", False
                if isinstance(declaration, Bitmask):
                    return f"{mine}(0)", False
                return mine, True
        raise AssertionError(target)

    def _zero_array(self, element: Type, dimensions: tuple[int, ...]) -> tuple[str, bool]:
        node = node_of(self.model, element)
        if is_octet(node) and len(dimensions) == 1:
            return f"b'\\0' * {dimensions[0]}", False
        code = self.bulk_code(node)
        if code is not None:
            shape = ", ".join(str(d) for d in dimensions)
            return f'lambda: _wire.zeros("{code}", {shape})', True
        inner, made = self._zero(element)
        text = f"{inner.removeprefix('lambda: ')}" if inner.startswith("lambda: ") else inner
        text = f"{text}()" if made and not inner.startswith("lambda: ") else text
        for size in reversed(dimensions):
            text = f"[{text} for _ in range({size})]"
        return f"lambda: {text}", True

    def bulk_code(self, element: Node) -> str | None:
        """Code of elements that are kept in a numpy array."""
        if isinstance(element, ScalarNode) and element.primitive is not Primitive.CHAR:
            return CODES[element.primitive]
        return None

    def limits(self, slot: Slot) -> Range | None:
        """Bounds of a number, those of its typedefs included."""
        limits, used = slot.range, slot.type
        while isinstance(used, NamedType):
            declaration = self.model.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            limits, used = within(limits, declaration.range), declaration.type
        return limits


def is_octet(element: Node) -> bool:
    return isinstance(element, ScalarNode) and element.primitive is Primitive.OCTET


def most(bound: int | None, what: str) -> str:
    if bound is not None:
        return str(bound)
    return "_wire.MAX_TEXT" if what == "string" else "_wire.MAX_COUNT"


def indented(lines: list[str]) -> list[str]:
    return [f"    {line}" for line in lines]


def quoted(text: str) -> str:
    """A string literal in double quotes, as ruff writes them."""
    body = repr(text)[1:-1] if "'" not in text else repr(text)[1:-1].replace("\\'", "'")
    if repr(text).startswith('"'):
        return repr(text)
    return '"' + body.replace('"', '\\"') + '"'
