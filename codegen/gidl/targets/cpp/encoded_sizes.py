"""The encoded size of a value: a constant part, and C++ statements that add the variable part."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import dropwhile

from gidl.targets.cpp.names import Locals
from gidl.targets.cpp.statements import block, loop, of, rows
from gidl.targets.cpp.type_text import Slot, Types
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


class Sizes(Types):
    def whole_size(
        self, slots: Sequence[Slot], total: str, taken: Collection[str]
    ) -> tuple[list[str], str]:
        """Returns statements that prepare the encoded size of all `slots`, and the expression for
        this size. If the expression is one sum, there are no statements."""
        constant, lines = 0, list[str]()
        for slot in slots:
            always, more = self.size(slot, total, Locals({*taken, total}))
            constant += always
            lines += more
        head = f"{total} += "
        rest = list(dropwhile(lambda line: line.startswith(head), lines))
        first = lines[: len(lines) - len(rest)]
        terms = [line.removeprefix(head).removesuffix(";") for line in first]
        terms = [str(constant)] * bool(constant or not terms) + terms
        if not rest:
            return [], " + ".join(terms)
        begun, *more = rows([f"std::size_t {total} = {terms[0]}", *(f"+ {t}" for t in terms[1:])])
        lines = [begun, *(f"    {line}" for line in more)]
        return [*lines[:-1], f"{lines[-1]};", *rest], total

    def size(self, slot: Slot, total: str, local: Locals) -> tuple[int, list[str]]:
        """Returns the constant part of the encoded size in bytes, and statements that add the
        variable part to `total`."""
        return self._size(slot.node, slot.expression, total, local)

    def _size(self, node: Node, x: str, total: str, local: Locals) -> tuple[int, list[str]]:
        match node:
            case ScalarNode() | EnumNode():
                return min_size_of(self.model, node), []
            case StringNode():
                return 5, [f"{total} += {of(x, 'size()')};"]
            case StructNode(name):
                fixed = self.layout.structs[name].fixed_size
                if fixed is not None:
                    return fixed, []
                return 0, [f"{total} += {of(x, 'encoded_size()')};"]
            case AppendableNode() | UnionNode(appendable=True):
                return 4, [f"{total} += {of(x, 'encoded_size()')};"]
            case UnionNode() | ObjectNode():
                return 0, [f"{total} += {of(x, 'encoded_size()')};"]
            case ArrayNode(element, dimensions):
                item = local.fresh("item")
                each, lines = self._size(element, item, total, local)
                if not lines:
                    return each * node.count, []
                for _ in dimensions[1:]:
                    outer = local.fresh("row")
                    lines = loop(item, outer, lines)
                    item = outer
                return each * node.count, loop(item, x, lines)
            case SequenceNode(element=element):
                item = local.fresh("item")
                each, lines = self._size(element, item, total, local)
                return 4, self._repeated(x, each, lines, total, loop(item, x, lines))
            case OptionalNode(element=element):
                each, lines = self._size(element, f"*{x}", total, local)
                if each:
                    lines = [f"{total} += {each};", *lines]
                return 1, block(f"if ({x})", lines)
            case MapNode(key, value):
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                key_size, key_lines = self._size(key, key_name, total, local)
                each, lines = self._size(value, value_name, total, local)
                inner = [*key_lines, *lines]
                whole = block(f"for (const auto& [{key_name}, {value_name}] : {x})", inner)
                return 4, self._repeated(x, key_size + each, inner, total, whole)
            case _:
                raise AssertionError(node)

    @staticmethod
    def _repeated(x: str, each: int, inner: list[str], total: str, whole: list[str]) -> list[str]:
        lines = [f"{total} += {each} * {of(x, 'size()')};"] if each else []
        return lines + (whole if inner else [])
