"""Prints Python text for values: type hints, default values and literals."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from gidl.model import (
    Bitmask,
    EnumDeclaration,
    EnumValue,
    ExceptionStruct,
    Member,
    Model,
    Primitive,
    Struct,
    Value,
)
from gidl.targets.groups import call, clauses
from gidl.targets.python import names
from gidl.targets.python.homes import Home, ModuleNames
from gidl.wire.wire_layout import FieldLayout, Layout
from gidl.wire.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    MapNode,
    Node,
    ObjectNode,
    OptionalNode,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
    UnionNode,
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


class Types:
    def __init__(self, model: Model, layout: Layout, module: ModuleNames) -> None:
        self.model = model
        self.layout = layout
        self.module = module  # names in the module that is printed

    def within(self, module: ModuleNames) -> Self:
        """Returns a copy of this object that writes type hints for another generated module."""
        return type(self)(self.model, self.layout, module)

    def hint(self, node: Node, sending: bool = False) -> str:
        """Returns the type hint of a value. With `sending`, the hint includes types that are
        accepted as input but never returned."""
        match node:
            case OptionalNode(element):
                return f"{self.hint(element, sending)} | None"
            case ScalarNode(Primitive.BOOLEAN):
                return "bool"
            case ScalarNode(Primitive.CHAR) | StringNode():
                return "str"
            case ScalarNode(kind):
                return "float" if kind.is_floating else "int"
            case SequenceNode(element) | ArrayNode(element):
                return self._several_hint(node, element, sending)
            case MapNode(key, value):
                return f"dict[{self.hint(key)}, {self.hint(value)}]"
            case (
                StructNode(name)
                | AppendableNode(name)
                | UnionNode(name)
                | EnumNode(name)
                | ObjectNode(name)
            ):
                return self.module.value(name)

    def _several_hint(self, node: SequenceNode | ArrayNode, element: Node, sending: bool) -> str:
        depth = len(node.dimensions) if isinstance(node, ArrayNode) else 1
        if is_octet(element) and depth == 1:
            return "bytes"
        code = bulk_code(element)
        if code is not None:
            numbers = f"_npt.NDArray[_np.{DTYPES[code]}]"
            return f"{numbers} | bytes" if sending and code == "B" and depth == 1 else numbers
        text = self.hint(element)
        for _ in range(depth):
            text = f"list[{text}]"
        return text

    def fields(self, struct: Struct) -> tuple[FieldLayout, ...]:
        """Returns the wire fields of all members, in the order of `Model.all_members`: the fields
        of the bases come first."""
        return self.layout.structs[struct.name].fields

    def words(self, struct: Struct) -> frozenset[str]:
        """Returns the names that the members of a struct cannot have in Python."""
        exception = isinstance(struct, ExceptionStruct)
        words = names.EXCEPTION_WORDS if exception else names.STRUCT_WORDS
        return self.words_beside([field.node for field in self.fields(struct)], words)

    def words_beside(self, nodes: Iterable[Node], words: frozenset[str]) -> frozenset[str]:
        """Returns `words`, and the names of the classes in the type hints of `nodes`."""
        return words | self.type_names(nodes)

    def literal(self, value: Value, node: Node) -> str:
        if isinstance(node, OptionalNode):
            return self.literal(value, node.element)
        match value:
            case EnumValue():
                return self._enumerator_literal(value)
            case bool() | str():
                return quoted(value) if isinstance(value, str) else str(value)
            case _:
                floating = isinstance(node, ScalarNode) and node.primitive.is_floating
                return repr(float(value)) if floating else str(value)

    def _enumerator_literal(self, value: EnumValue) -> str:
        declaration = self.model.find(value.enum)
        mine = self.module.value(value.enum)
        if not isinstance(declaration, Bitmask):
            return f"{mine}.{names.enumerator(value.literal)}"
        flags = [f.name for f in declaration.flags if value.number >> f.position & 1]
        return " | ".join(f"{mine}.{names.enumerator(flag)}" for flag in flags) or f"{mine}(0)"

    def initial(self, member: Member, node: Node) -> tuple[str, bool]:
        """Returns the text of the default of a member. Also returns whether this text is a factory,
        which Python calls for each new object."""
        if isinstance(node, OptionalNode):
            return "None", False
        if member.default is not None:
            return self.literal(member.default, node), False
        return self.zero(node)

    def zero(self, node: Node) -> tuple[str, bool]:
        match node:
            case OptionalNode():
                return "None", False
            case ScalarNode(Primitive.BOOLEAN):
                return "False", False
            case ScalarNode(Primitive.CHAR):
                return '"\\0"', False
            case ScalarNode(kind):
                return ("0.0" if kind.is_floating else "0"), False
            case StringNode():
                return '""', False
            case MapNode():
                return "dict", True
            case SequenceNode(element):
                if is_octet(element):
                    return 'b""', False
                code = bulk_code(element)
                return (f'lambda: _wire.zeros("{code}", 0)' if code else "list"), True
            case ArrayNode(element, dimensions):
                return self._zero_array(element, dimensions)
            case EnumNode(name):
                declaration = self.model.find(name)
                mine = self.module.value(name)
                if isinstance(declaration, EnumDeclaration):
                    return f"{mine}.{names.enumerator(declaration.initial.name)}", False
                if isinstance(declaration, Bitmask):
                    return f"{mine}(0)", False
                return mine, True
            case StructNode(name) | AppendableNode(name) | UnionNode(name) | ObjectNode(name):
                return self.module.value(name), True

    def _zero_array(self, element: Node, dimensions: tuple[int, ...]) -> tuple[str, bool]:
        if is_octet(element) and len(dimensions) == 1:
            return f"b'\\0' * {dimensions[0]}", False
        code = bulk_code(element)
        if code is not None:
            return f"lambda: {call('_wire.zeros', quoted(code), *map(str, dimensions))}", True
        inner, made = self.zero(element)
        text = inner.removeprefix("lambda: ")
        text = f"{text}()" if made and text == inner else text
        return f"lambda: {repeated(text, dimensions)}", True

    def type_names(self, nodes: Iterable[Node]) -> frozenset[str]:
        """Returns the names of the classes in the type hints of `nodes`. Each name is the one that
        the class has in the module that defines the class, even if it is imported under another
        name."""
        return frozenset(home.name for node in nodes for home in self.named(node))

    def named(self, node: Node) -> set[Home]:
        """Returns the classes that the type hint of a value uses."""
        match node:
            case OptionalNode(element) | SequenceNode(element) | ArrayNode(element):
                return self.named(element)
            case MapNode(key, value):
                return self.named(key) | self.named(value)
            case (
                StructNode(name)
                | AppendableNode(name)
                | UnionNode(name)
                | EnumNode(name)
                | ObjectNode(name)
            ):
                return {self.module.homes.value(name)}
            case _:
                return set()


def bulk_code(element: Node) -> str | None:
    """Returns the code of the number type if elements of this type are kept in a numpy array.
    Returns None for other elements."""
    if isinstance(element, ScalarNode) and element.primitive is not Primitive.CHAR:
        return CODES[element.primitive]
    return None


def is_octet(element: Node) -> bool:
    return isinstance(element, ScalarNode) and element.primitive is Primitive.OCTET


def repeated(text: str, dimensions: tuple[int, ...]) -> str:
    """Returns a nested list comprehension, which evaluates the expression `text` for each
    element."""
    for size in reversed(dimensions):
        text = clauses([text, f"for _ in range({size})"], "[", "]")
    return text


def quoted(text: str) -> str:
    """Returns a string literal in double quotes, as ruff formats it."""
    body = repr(text)[1:-1] if "'" not in text else repr(text)[1:-1].replace("\\'", "'")
    if repr(text).startswith('"'):
        return repr(text)
    return '"' + body.replace('"', '\\"') + '"'
