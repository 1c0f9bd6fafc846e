"""Expressions that read a value.

Each is one boolean expression, so that fields chain with && and the first refusal ends it;
composed values pass a lambda to the functions of gecos/wire/fields.hpp.
"""

from __future__ import annotations

from gidl.model import (
    ArrayType,
    MapType,
    Range,
    SequenceType,
    Type,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.lower.statements import (
    call,
    indented,
    with_lambda,
)
from gidl.targets.cpp.lower.types import Slot, Types, is_bulk, range_test
from gidl.targets.naming import LocalNames
from gidl.wire_layout import min_size_of, node_of
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


class Reading(Types):
    def decode(self, slot: Slot, source: str, local: LocalNames) -> list[str]:
        """Lines of a boolean expression."""
        node = node_of(self.model, slot.type, slot.optional)
        limits = self.limits(slot)
        return self._decode(node, slot.type, slot.expression, slot.label, source, local, limits)

    def _decode(
        self,
        node: Node,
        used: Type,
        x: str,
        label: str,
        source: str,
        local: LocalNames,
        limits: Range | None = None,
    ) -> list[str]:
        field = f'"{label}"'
        target = self.model.target(used)
        match node:
            case OptionalNode(element=element):
                inner_name = local.fresh("value")
                inner = self._decode(element, used, inner_name, label, source, local, limits)
                head = f"gecos::wire::get_optional({source}, {x}, {field}, "
                return with_lambda(head, self.type(used), inner_name, inner)
            case ScalarNode(primitive):
                lines = [f"{source}.get({x}, {field})"]
                test = range_test(x, primitive, limits)
                if test:
                    size = primitive.size
                    lines[0] += " &&"
                    lines.append(f"gecos::wire::in_range({source}, {test}, {size}, {field})")
                return lines
            case EnumNode(name):
                scope = "::".join(names.scope_of(self.model, name))
                prefix = f"{scope}::" if scope else "::"
                return [f"{prefix}decode_enum({source}, {x}, {field})"]
            case StringNode(bound):
                return [f"{source}.get_string({x}, {_bound(bound)}, {field})"]
            case StructNode() | ObjectNode() | UnionNode(appendable=False):
                return [call(x, f"decode({source})")]
            case AppendableNode() | UnionNode():
                return [f"gecos::wire::get_block({source}, {x}, {field})"]
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                return self._decode_array(
                    element, target.element, dimensions, x, label, source, local
                )
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                if is_bulk(element):
                    bulk = f"gecos::wire::get_numbers({source}, {x}, {_bound(bound)}, {field})"
                    return [bulk]
                item = local.fresh("item")
                limits = self.limits(Slot(item, label, target.element))
                inner = self._decode(element, target.element, item, label, source, local, limits)
                least = min_size_of(self.model, element)
                head = (
                    f"gecos::wire::get_sequence({source}, {x}, {least}, {_bound(bound)}, {field}, "
                )
                return with_lambda(head, self.type(target.element), item, inner)
            case MapNode(key, value, bound):
                assert isinstance(target, MapType)
                least = min_size_of(self.model, key) + min_size_of(self.model, value)
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                key_lines = self._decode(key, target.key, key_name, label, source, local)
                lines = self._decode(value, target.value, value_name, label, source, local)
                head = f"gecos::wire::get_map({source}, {x}, {least}, {_bound(bound)}, {field}, "
                first = with_lambda(head, self.type(target.key), key_name, key_lines)
                first[-1] = first[-1].removesuffix(")") + ","
                second = with_lambda("", self.type(target.value), value_name, lines)
                return [*first, *indented(second)]
            case _:
                raise AssertionError(node)

    def _decode_array(
        self,
        element: Node,
        used: Type,
        dimensions: tuple[int, ...],
        x: str,
        label: str,
        source: str,
        local: LocalNames,
    ) -> list[str]:
        if len(dimensions) == 1 and is_bulk(element):
            return [f'{source}.get_array({x}, "{label}")']
        item = local.fresh("item" if len(dimensions) == 1 else "row")
        if len(dimensions) == 1:
            item_type = self.type(used)
            inner = self._decode(element, used, item, label, source, local)
        else:
            item_type = self.type(ArrayType(used, dimensions[1:]))
            inner = self._decode_array(element, used, dimensions[1:], item, label, source, local)
        return with_lambda(f"gecos::wire::get_each({x}, ", item_type, item, inner)


def _bound(bound: int | None) -> str:
    return "gecos::wire::npos" if bound is None else str(bound)
