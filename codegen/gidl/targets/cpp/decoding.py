"""Prints C++ expressions that decode a value.

One boolean expression decodes each value. The expressions of several fields are joined by &&, so
the first failure ends decoding. For the elements of a value, a lambda is passed to a function of
gecos/wire/fields.hpp.
"""

from __future__ import annotations

from gidl.targets.cpp.names import Locals
from gidl.targets.cpp.ranges import bounds, limits_text
from gidl.targets.cpp.statements import indented, of, quoted, with_lambda
from gidl.targets.cpp.type_text import Slot, Types, is_bulk
from gidl.targets.groups import call
from gidl.wire.wire_layout import min_size_of
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


class Reading(Types):
    def decode(self, slot: Slot, source: str, local: Locals) -> list[str]:
        """Returns the lines of a boolean expression that decodes a value. The expression is false
        if decoding fails."""
        if slot.bulk and isinstance(slot.node, SequenceNode):
            bound, field = _bound(slot.node.bound), f'"{slot.label}"'
            return [f"{source}.get_bulk({slot.expression}, {bound}, {field})"]
        return self._decode(slot.node, slot.expression, slot.label, source, local)

    def _decode(self, node: Node, x: str, label: str, source: str, local: Locals) -> list[str]:
        field = f'"{label}"'
        match node:
            case OptionalNode(element=element):
                inner_name = local.fresh("value")
                inner = self._decode(element, inner_name, label, source, local)
                head = f"gecos::wire::get_optional({source}, {x}, {field}, "
                return with_lambda(head, inner_name, inner)
            case ScalarNode():
                read = f"{source}.get({x}, {field})"
                if node.limits is None:
                    return [read]
                shown = limits_text(node)
                within = call("gecos::wire::within", source, x, bounds(node), field, shown)
                return [f"{read} &&", within]
            case EnumNode(name):
                return [f"{self.function(name, 'decode_enum')}({source}, {x}, {field})"]
            case StringNode(bound):
                return [f"{source}.get_string({x}, {_bound(bound)}, {field})"]
            case StructNode() | ObjectNode() | UnionNode(appendable=False):
                return [of(x, f"decode({source})")]
            case AppendableNode() | UnionNode():
                return [f"gecos::wire::get_block({source}, {x}, {field})"]
            case ArrayNode(element, dimensions):
                return self._decode_array(element, len(dimensions), x, label, source, local)
            case SequenceNode(element, bound):
                if isinstance(element, ScalarNode) and is_bulk(element):
                    bulk = f"gecos::wire::get_numbers({source}, {x}, {_bound(bound)}, {field})"
                    return _bulk(bulk, element, x, label, source)
                item = local.fresh("item")
                inner = self._decode(element, item, label, source, local)
                least = min_size_of(self.model, element)
                head = (
                    f"gecos::wire::get_sequence({source}, {x}, {least}, {_bound(bound)}, {field}, "
                )
                return with_lambda(head, item, inner)
            case MapNode(key, value, bound):
                least = min_size_of(self.model, key) + min_size_of(self.model, value)
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                key_lines = self._decode(key, key_name, label, source, local)
                lines = self._decode(value, value_name, label, source, local)
                head = f"gecos::wire::get_map({source}, {x}, {least}, {_bound(bound)}, {field}, "
                first = with_lambda(head, key_name, key_lines)
                first[-1] = first[-1].removesuffix(")") + ","
                return [*first, *indented(with_lambda("", value_name, lines))]

    def _decode_array(
        self, element: Node, depth: int, x: str, label: str, source: str, local: Locals
    ) -> list[str]:
        if depth == 1 and isinstance(element, ScalarNode) and is_bulk(element):
            return _bulk(f'{source}.get_array({x}, "{label}")', element, x, label, source)
        item = local.fresh("item" if depth == 1 else "row")
        if depth == 1:
            inner = self._decode(element, item, label, source, local)
        else:
            inner = self._decode_array(element, depth - 1, item, label, source, local)
        return with_lambda(f"gecos::wire::get_each({x}, ", item, inner)


def _bulk(read: str, number: ScalarNode, x: str, label: str, source: str) -> list[str]:
    """Returns an expression that decodes all numbers at once, and then checks that they are in
    their range."""
    if number.limits is None:
        return [read]
    return [
        f"{read} &&",
        call(
            "gecos::wire::all_within", source, x, bounds(number), quoted(label), limits_text(number)
        ),
    ]


def _bound(bound: int | None) -> str:
    return "gecos::wire::npos" if bound is None else str(bound)
