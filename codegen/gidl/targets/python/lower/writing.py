"""Statements that append a value to `out`."""

from __future__ import annotations

from gidl.model import Bitset, EnumDeclaration, Primitive
from gidl.targets.groups import call, group
from gidl.targets.naming import LocalNames
from gidl.targets.python.lower.reading import range_arguments
from gidl.targets.python.lower.runs import Leaf, Runs
from gidl.targets.python.lower.types import (
    CODES,
    Slot,
    bulk_code,
    indented,
    is_octet,
    most,
    quoted,
)
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


class Writing(Runs):
    def encode(self, slot: Slot, local: LocalNames) -> list[str]:
        """Statements that append the value to `out`."""
        return _Statements(self, slot, local).encode(slot.node, slot.expression)


class _Statements:
    """Those of one value, which all call it by its label."""

    def __init__(self, lowering: Writing, slot: Slot, local: LocalNames) -> None:
        self._lowering = lowering
        self._label = slot.label
        self._quoted = quoted(slot.label)
        self._secret = slot.secret
        self._local = local

    def encode(self, node: Node, x: str) -> list[str]:
        module = self._lowering.module
        match node:
            case OptionalNode(element):
                return self._encode_optional(element, x)
            case ScalarNode(Primitive.CHAR):
                return [_append(call("_wire.char", x, self._quoted))]
            case ScalarNode(primitive):
                return self._encode_number(CODES[primitive], node, x)
            case EnumNode(name, wire):
                declaration = self._lowering.model.find(name)
                if isinstance(declaration, Bitset):
                    expected = call("_wire.expect", x, module.value(name), self._quoted)
                    return [expected, f"out.append({x}.pack())"]
                code = CODES[wire]
                signed = isinstance(declaration, EnumDeclaration)
                return self._encode_number(code if signed else code.upper(), node, x)
            case StringNode(bound):
                put = "_wire.secret_string" if self._secret else "_wire.string"
                return [_append(call(put, x, most(bound, "string"), self._quoted))]
            case StructNode(name) | ObjectNode(name) | UnionNode(name, False):
                return [call("_wire.put", x, module.value(name), "out", self._quoted)]
            case AppendableNode(name) | UnionNode(name):
                return [call("_wire.put_block", x, module.value(name), "out", self._quoted)]
            case SequenceNode(element, bound):
                return self._encode_sequence(element, most(bound, "count"), x)
            case ArrayNode(element, dimensions):
                return self._encode_array(element, dimensions, x)
            case MapNode(key, value, bound):
                return self._encode_map(key, value, most(bound, "count"), x)

    def _encode_optional(self, element: Node, x: str) -> list[str]:
        head: list[str] = []
        if "." in x:  # a name of its own, so that a type checker sees what None excludes
            given, x = x, self._local.fresh("value")
            head = [f"{x} = {given}"]
        return [
            *head,
            f"if {x} is None:",
            '    out.append(b"\\0")',
            "else:",
            '    out.append(b"\\1")',
            *indented(self.encode(element, x)),
        ]

    def _encode_number(self, code: str, node: ScalarNode | EnumNode, x: str) -> list[str]:
        written = _append(call("_wire.number", x, quoted(code), self._quoted))
        return [written, *self._lowering.check_leaf(Leaf(code, x, self._label, node))]

    def _encode_sequence(self, element: Node, limit: str, x: str) -> list[str]:
        if is_octet(element):
            return [f"out += {call('_wire.octets', x, limit, self._quoted)}"]
        code = bulk_code(element)
        if code is not None:
            rest = (quoted(code), limit, self._quoted, *range_arguments(element))
            return [f"out += {call('_wire.numbers', x, *rest)}"]
        item = self._local.fresh("item")
        return [
            self._counted(x, limit),
            f"for {item} in {x}:",
            *indented(self.encode(element, item)),
        ]

    def _encode_array(self, element: Node, dimensions: tuple[int, ...], x: str) -> list[str]:
        if is_octet(element) and len(dimensions) == 1:
            return [_append(call("_wire.fixed_octets", x, str(dimensions[0]), self._quoted))]
        code = bulk_code(element)
        if code is not None:
            shape = group([f"{size}" for size in dimensions]) if dimensions[1:] else None
            shape = shape or f"({dimensions[0]},)"
            rest = (quoted(code), shape, self._quoted, *range_arguments(element))
            return [_append(call("_wire.fixed", x, *rest))]
        item = self._local.fresh("row" if dimensions[1:] else "item")
        inner = (
            self._encode_array(element, dimensions[1:], item)
            if dimensions[1:]
            else self.encode(element, item)
        )
        exactly = call("_wire.exactly", x, str(dimensions[0]), self._quoted)
        return [f"for {item} in {exactly}:", *indented(inner)]

    def _encode_map(self, key: Node, value: Node, limit: str, x: str) -> list[str]:
        name, entry = self._local.fresh("key"), self._local.fresh("entry")
        return [
            self._counted(x, limit),
            f"for {name}, {entry} in {call('_wire.entries', x, self._quoted)}:",
            *indented([*self.encode(key, name), *self.encode(value, entry)]),
        ]

    def _counted(self, x: str, limit: str) -> str:
        return _append(call("_wire.counted", x, limit, self._quoted))


def _append(text: str) -> str:
    return call("out.append", text)
