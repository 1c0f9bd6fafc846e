"""How a type describes itself to gecos.wire.shapes, which JSON is read and written with."""

from __future__ import annotations

from gidl.model import Bitmask, EnumDeclaration, Primitive
from gidl.targets.groups import call, group
from gidl.targets.python import names
from gidl.targets.python.lower.types import CODES, Types, bulk_code, is_octet, quoted
from gidl.wire_nodes import (
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


class Shapes(Types):
    def shape(self, node: Node) -> str:
        match node:
            case OptionalNode(element):
                return call("_shapes.Optional", self.shape(element))
            case ScalarNode(Primitive.CHAR):
                return "_shapes.Text(1)"
            case ScalarNode(kind):
                return call("_shapes.Number", quoted(CODES[kind]))
            case StringNode():
                return "_shapes.Text()"
            case SequenceNode(element):
                return self._items(element, ())
            case ArrayNode(element, dimensions):
                return self._items(element, dimensions)
            case MapNode(key, value):
                return call("_shapes.Entries", self.shape(key), self.shape(value))
            case EnumNode(name):
                return self._named(name)
            case StructNode(name) | AppendableNode(name) | UnionNode(name) | ObjectNode(name):
                return call("_shapes.Value", self.module.value(name))

    def member_shape(self, name: str, attribute: str, node: Node, secret: bool = False) -> str:
        more = [f"attribute={quoted(attribute)}"] if attribute != name else []
        more += ["secret=True"] if secret else []
        return call("_shapes.Member", quoted(name), self.shape(node), *more)

    def _items(self, element: Node, sizes: tuple[int, ...]) -> str:
        """Of an array, or without sizes of a sequence."""
        if is_octet(element) and len(sizes) < 2:
            return call("_shapes.Octets", *map(str, sizes))
        code = bulk_code(element)
        if code is not None:
            shape = group(map(str, sizes)) if sizes[1:] else f"({sizes[0]},)" if sizes else ""
            return call("_shapes.Array", quoted(code), *([shape] if shape else []))
        text = self.shape(element)
        for size in reversed(sizes):
            text = call("_shapes.Items", text, str(size))
        return text if sizes else call("_shapes.Items", text)

    def _named(self, name: str) -> str:
        declaration = self.model.find(name)
        mine = self.module.value(name)
        if isinstance(declaration, EnumDeclaration):
            kind, words = "Enumerators", [e.name for e in declaration.enumerators]
        elif isinstance(declaration, Bitmask):
            kind, words = "Flags", [f.name for f in declaration.flags]
        else:
            return call("_shapes.Value", mine)
        renamed = [
            f"{quoted(names.enumerator(word))}: {quoted(word)}"
            for word in words
            if names.enumerator(word) != word
        ]
        return call(f"_shapes.{kind}", mine, *([group(renamed, "{", "}")] if renamed else []))
