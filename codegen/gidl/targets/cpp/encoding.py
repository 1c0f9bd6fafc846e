"""Prints C++ statements that encode a value."""

from __future__ import annotations

from gidl.model import (
    Bitset,
    Primitive,
)
from gidl.targets.cpp.names import Locals
from gidl.targets.cpp.statements import block, loop, of
from gidl.targets.cpp.type_text import PRIMITIVES, Slot, Types, is_bulk
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


class Writing(Types):
    def encode(self, slot: Slot, to: str, local: Locals) -> list[str]:
        if slot.bulk:
            return [f"{to}.put_bulk({slot.expression});"]
        return self._encode(slot.node, slot.expression, to, local)

    def _encode(self, node: Node, x: str, to: str, local: Locals) -> list[str]:
        match node:
            case ScalarNode():
                return [f"{to}.put({x});"]
            case EnumNode(name, wire):
                if isinstance(self.model.find(name), Bitset):
                    return [f"{to}.put({of(x, 'bits()')});"]
                return [f"{to}.put(static_cast<{PRIMITIVES[wire]}>({x}));"]
            case StringNode():
                return [f"{to}.put_string({x});"]
            case StructNode() | ObjectNode() | UnionNode(appendable=False):
                return [f"{of(x, f'encode({to})')};"]
            case AppendableNode() | UnionNode():
                size = of(x, "encoded_size()")
                return [f"{to}.put_count({size});", f"{of(x, f'encode({to})')};"]
            case ArrayNode(element, dimensions):
                return self._encode_array(element, len(dimensions), x, to, local)
            case SequenceNode(element=element):
                lines = self._encode_array(element, 1, x, to, local)
                return [f"{to}.put_count({of(x, 'size()')});", *lines]
            case OptionalNode(element=element):
                inner = self._encode(element, f"*{x}", to, local)
                return [f"{to}.put({of(x, 'has_value()')});", *block(f"if ({x})", inner)]
            case MapNode(key, value):
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                inner = [
                    *self._encode(key, key_name, to, local),
                    *self._encode(value, value_name, to, local),
                ]
                head = f"for (const auto& [{key_name}, {value_name}] : {x})"
                return [f"{to}.put_count({of(x, 'size()')});", *block(head, inner)]
            case _:
                raise AssertionError(node)

    def _encode_array(self, element: Node, depth: int, x: str, to: str, local: Locals) -> list[str]:
        if depth == 1 and is_bulk(element):
            return [f"{to}.put_array({x});"]
        item = local.fresh("item" if depth == 1 else "row")
        if depth == 1:
            inner = self._encode(element, item, to, local)
        else:
            inner = self._encode_array(element, depth - 1, item, to, local)
        boolean = depth == 1 and element == ScalarNode(Primitive.BOOLEAN)
        return loop(item, x, inner, "const bool" if boolean else "const auto&")
