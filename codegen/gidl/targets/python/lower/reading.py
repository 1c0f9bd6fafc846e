"""Expressions that read a value from `source`."""

from __future__ import annotations

from gidl.model import Bitset, EnumDeclaration, Primitive, Range
from gidl.targets.groups import call, clauses
from gidl.targets.python.lower.runs import Runs
from gidl.targets.python.lower.types import (
    CODES,
    Slot,
    bulk_code,
    is_octet,
    most,
    quoted,
    repeated,
    sent_bounds,
)
from gidl.wire_layout import min_size_of
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


class Reading(Runs):
    def decode(self, slot: Slot) -> str:
        """An expression that reads the value from `source`."""
        return self._decode(slot.node, quoted(slot.label))

    def _decode(self, node: Node, label: str) -> str:
        match node:
            case OptionalNode(element):
                there = call("source.number", '"?"', label)
                return clauses([self._decode(element, label), f"if {there}", "else None"])
            case ScalarNode():
                return _decode_scalar(node, label)
            case EnumNode(name, wire):
                declaration = self.model.find(name)
                if isinstance(declaration, Bitset):
                    return call(f"{self.module.value(name)}.unpack", "source", label)
                signed = isinstance(declaration, EnumDeclaration)
                code = CODES[wire] if signed else CODES[wire].upper()
                number = call("source.number", quoted(code), label)
                return self.enumerator(name, number, label, wire.size)
            case StringNode(bound):
                return call("source.string", most(bound, "count"), label)
            case StructNode(name) | ObjectNode(name) | UnionNode(name, False):
                return f"{self.module.value(name)}.decode(source)"
            case AppendableNode(name) | UnionNode(name):
                return call(f"{self.module.value(name)}.decode", call("source.block", label))
            case SequenceNode(element, bound):
                return self._decode_sequence(element, most(bound, "count"), label)
            case ArrayNode(element, dimensions):
                return self._decode_array(element, dimensions, label)
            case MapNode(key, value, bound):
                least = min_size_of(self.model, key) + min_size_of(self.model, value)
                return call(
                    "source.mapping",
                    f"lambda: {self._decode(key, label)}",
                    f"lambda: {self._decode(value, label)}",
                    str(least),
                    most(bound, "count"),
                    label,
                )

    def _decode_sequence(self, element: Node, limit: str, label: str) -> str:
        code = bulk_code(element)
        if code is not None and not is_octet(element):
            bounds = range_arguments(element)
            return call("source.numbers", quoted(code), limit, label, *bounds)
        count = call("source.count", str(min_size_of(self.model, element)), limit, label)
        if is_octet(element):
            return call("source.octets", count, label)
        return clauses([self._decode(element, label), f"for _ in range({count})"], "[", "]")

    def _decode_array(self, element: Node, dimensions: tuple[int, ...], label: str) -> str:
        if is_octet(element) and len(dimensions) == 1:
            return call("source.octets", str(dimensions[0]), label)
        code = bulk_code(element)
        if code is None:
            return repeated(self._decode(element, label), dimensions)
        count = str(ArrayNode(element, dimensions).count)
        text = call("source.array", quoted(code), count, label, *range_arguments(element))
        return call(f"{text}.reshape", *map(str, dimensions)) if len(dimensions) > 1 else text


def _decode_scalar(node: ScalarNode, label: str) -> str:
    if node.primitive is Primitive.CHAR:
        return f"chr({call('source.number', quoted('B'), label)})"
    code = quoted(CODES[node.primitive])
    if node.bounds is None:
        return call("source.number", code, label)
    bounds: Range = node.bounds
    return call("source.ranged", code, repr(bounds.minimum), repr(bounds.maximum), label)


def range_arguments(element: Node) -> tuple[str, ...]:
    """What codecs of arrays are told of the range of their elements. numpy compares in the
    precision of the array."""
    if not isinstance(element, ScalarNode):
        return ()
    limits = sent_bounds(element) if element.primitive.is_floating else element.limits
    return () if limits is None else (repr(limits.minimum), repr(limits.maximum))
