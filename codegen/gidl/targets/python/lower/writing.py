"""Statements that append a value to `out`."""

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
from gidl.targets.naming import LocalNames
from gidl.targets.python import names
from gidl.targets.python.lower.runs import Leaf, Runs
from gidl.targets.python.lower.types import (
    CODES,
    Slot,
    indented,
    is_octet,
    most,
)
from gidl.wire_layout import node_of
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


class Writing(Runs):
    def encode(self, slot: Slot, local: LocalNames) -> list[str]:
        """Statements that append the value to `out`."""
        limits = self.limits(slot)
        if not slot.optional:
            return self._encode(slot.type, slot.expression, slot.label, limits, local)
        x = slot.expression
        head: list[str] = []
        if "." in x:  # a name of its own, so that a type checker sees what None excludes
            x = local.fresh("value")
            head = [f"{x} = {slot.expression}"]
        inner = self._encode(slot.type, x, slot.label, limits, local)
        return [
            *head,
            f"if {x} is None:",
            '    out.append(b"\\0")',
            "else:",
            '    out.append(b"\\1")',
            *indented(inner),
        ]

    def _encode(
        self, used: Type, x: str, label: str, limits: Range | None, local: LocalNames
    ) -> list[str]:
        node = node_of(self.model, used)
        target = self.model.target(used)
        match node:
            case ScalarNode(Primitive.CHAR):
                return [f'out.append(_wire.char({x}, "{label}"))']
            case ScalarNode(primitive):
                leaf = Leaf(CODES[primitive], x, label, used, limits)
                return [
                    f'out.append(_wire.number({x}, "{leaf.code}", "{label}"))',
                    *self.check_leaf(leaf),
                ]
            case EnumNode(name, wire):
                declaration = self.model.find(name)
                if isinstance(declaration, Bitset):
                    kind = names.type_name(self.model, name)
                    expected = f'_wire.expect({x}, {kind}, "{label}")'
                    return [expected, f"out.append({x}.pack())"]
                code = CODES[wire]
                code = code if isinstance(declaration, EnumDeclaration) else code.upper()
                leaf = Leaf(code, x, label, used, None)
                return [
                    f'out.append(_wire.number({x}, "{code}", "{label}"))',
                    *self.check_leaf(leaf),
                ]
            case StringNode(bound):
                return [f'out.append(_wire.string({x}, {most(bound, "string")}, "{label}"))']
            case StructNode(name) | ObjectNode(name) | UnionNode(name, False):
                kind = names.value_name(self.model, name)
                return [f'_wire.put({x}, {kind}, out, "{label}")']
            case AppendableNode(name) | UnionNode(name):
                kind = names.type_name(self.model, name)
                return [f'_wire.put_block({x}, {kind}, out, "{label}")']
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                limits = self.limits(Slot(x, label, target.element))
                return self._encode_sequence(
                    element, target.element, bound, x, label, limits, local
                )
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                limits = self.limits(Slot(x, label, target.element))
                return self._encode_array(
                    element, target.element, dimensions, x, label, limits, local
                )
            case MapNode(bound=bound):
                assert isinstance(target, MapType)
                key, value = local.fresh("key"), local.fresh("entry")
                inner = [
                    *self._encode(target.key, key, label, None, local),
                    *self._encode(target.value, value, label, None, local),
                ]
                return [
                    f'out.append(_wire.count(_len({x}), {most(bound, "count")}, "{label}"))',
                    f"for {key}, {value} in _sorted({x}.items(), key=_wire.first):",
                    *indented(inner),
                ]
        raise AssertionError(node)

    def _encode_sequence(
        self,
        element: Node,
        used: Type,
        bound: int | None,
        x: str,
        label: str,
        limits: Range | None,
        local: LocalNames,
    ) -> list[str]:
        limit = most(bound, "count")
        if is_octet(element):
            return [f'out += _wire.octets({x}, {limit}, "{label}")']
        code = self.bulk_code(element)
        if code is not None:
            bounds = range_arguments(limits)
            return [f'out += _wire.numbers({x}, "{code}", {limit}, "{label}"{bounds})']
        item = local.fresh("item")
        return [
            f'out.append(_wire.count(_len({x}), {limit}, "{label}"))',
            f"for {item} in {x}:",
            *indented(self._encode(used, item, label, limits, local)),
        ]

    def _encode_array(
        self,
        element: Node,
        used: Type,
        dimensions: tuple[int, ...],
        x: str,
        label: str,
        limits: Range | None,
        local: LocalNames,
    ) -> list[str]:
        if is_octet(element) and len(dimensions) == 1:
            return [f'out.append(_wire.fixed_octets({x}, {dimensions[0]}, "{label}"))']
        code = self.bulk_code(element)
        if code is not None:
            shape = ", ".join(str(d) for d in dimensions)
            bounds = range_arguments(limits)
            return [f'out.append(_wire.fixed({x}, "{code}", ({shape},), "{label}"{bounds}))']
        item = local.fresh("item" if len(dimensions) == 1 else "row")
        if len(dimensions) == 1:
            inner = self._encode(used, item, label, limits, local)
        else:
            inner = self._encode_array(element, used, dimensions[1:], item, label, limits, local)
        return [f'for {item} in _wire.exactly({x}, {dimensions[0]}, "{label}"):', *indented(inner)]


def range_arguments(limits: Range | None) -> str:
    return "" if limits is None else f", {limits.minimum}, {limits.maximum}"
