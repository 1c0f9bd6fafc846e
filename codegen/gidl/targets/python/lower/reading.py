"""Expressions that read a value from `source`."""

from __future__ import annotations

from gidl.model import (
    ArrayType,
    Bitset,
    EnumDeclaration,
    MapType,
    Primitive,
    Range,
    SequenceType,
    Type,
)
from gidl.targets.python import names
from gidl.targets.python.lower.runs import Runs, as_read
from gidl.targets.python.lower.types import (
    CODES,
    Slot,
    is_octet,
    most,
)
from gidl.targets.python.lower.writing import range_arguments
from gidl.wire_layout import min_size_of, node_of
from gidl.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    MapNode,
    Node,
    ObjectNode,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
    UnionNode,
)


class Reading(Runs):
    def decode(self, slot: Slot) -> str:
        """An expression that reads the value from `source`."""
        limits = self.limits(slot)
        text = self._decode(slot.type, slot.label, limits)
        if slot.optional:
            return f'({text} if source.number("?", "{slot.label}") else None)'
        return text

    def _decode(self, used: Type, label: str, limits: Range | None) -> str:
        node = node_of(self.model, used)
        target = self.model.target(used)
        match node:
            case ScalarNode(Primitive.CHAR):
                return f'chr(source.number("B", "{label}"))'
            case ScalarNode(primitive):
                code = CODES[primitive]
                if self._outside("x", used, limits):
                    assert limits is not None
                    single = primitive is Primitive.FLOAT
                    bounds = f"{as_read(limits.minimum, single)}, {as_read(limits.maximum, single)}"
                    return f'source.ranged("{code}", {bounds}, "{label}")'
                return f'source.number("{code}", "{label}")'
            case EnumNode(name, wire):
                declaration = self.model.find(name)
                if isinstance(declaration, Bitset):
                    return f'{names.type_name(self.model, name)}.unpack(source, "{label}")'
                signed = isinstance(declaration, EnumDeclaration)
                code = CODES[wire] if signed else CODES[wire].upper()
                number = f'source.number("{code}", "{label}")'
                return self._enumerator(name, number, label, wire.size)
            case StringNode(bound):
                return f'source.string({most(bound, "count")}, "{label}")'
            case StructNode(name) | ObjectNode(name) | UnionNode(name, False):
                return f"{names.value_name(self.model, name)}.decode(source)"
            case AppendableNode(name) | UnionNode(name):
                return f'{names.type_name(self.model, name)}.decode(source.block("{label}"))'
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                limits = self.limits(Slot("", label, target.element))
                least = min_size_of(self.model, element)
                bulk = self.bulk_code(element)
                if bulk is not None and not is_octet(element):
                    rest = f'{most(bound, "count")}, "{label}"{range_arguments(limits)}'
                    return f'source.numbers("{bulk}", {rest})'
                count = f'source.count({least}, {most(bound, "count")}, "{label}")'
                if is_octet(element):
                    return f'source.octets({count}, "{label}")'
                read = self._decode(target.element, label, limits)
                return f"[{read} for _ in range({count})]"
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                limits = self.limits(Slot("", label, target.element))
                return self._decode_array(element, target.element, dimensions, label, limits)
            case MapNode(key, value, bound):
                assert isinstance(target, MapType)
                least = min_size_of(self.model, key) + min_size_of(self.model, value)
                read_key = self._decode(target.key, label, None)
                read_value = self._decode(target.value, label, None)
                return (
                    f"source.mapping(lambda: {read_key}, lambda: {read_value}, "
                    f'{least}, {most(bound, "count")}, "{label}")'
                )
        raise AssertionError(node)

    def _decode_array(
        self,
        element: Node,
        used: Type,
        dimensions: tuple[int, ...],
        label: str,
        limits: Range | None,
    ) -> str:
        if is_octet(element) and len(dimensions) == 1:
            return f'source.octets({dimensions[0]}, "{label}")'
        code = self.bulk_code(element)
        if code is not None:
            total = 1
            for size in dimensions:
                total *= size
            text = f'source.array("{code}", {total}, "{label}"{range_arguments(limits)})'
            shape = ", ".join(str(d) for d in dimensions)
            return f"{text}.reshape({shape})" if len(dimensions) > 1 else text
        text = self._decode(used, label, limits)
        for size in reversed(dimensions):
            text = f"[{text} for _ in range({size})]"
        return text
