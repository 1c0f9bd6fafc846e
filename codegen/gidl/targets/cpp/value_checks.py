"""Prints C++ statements that check whether a value may be sent. If the value must not be sent, the
statements return the reason."""

from __future__ import annotations

from collections.abc import Callable

from gidl.model import (
    Bitset,
    Model,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.names import Locals
from gidl.targets.cpp.ranges import bounds, limits_text, range_test
from gidl.targets.cpp.statements import block, loop, of, quoted
from gidl.targets.cpp.type_text import Slot, Types, is_bulk
from gidl.targets.groups import call
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

Refuse = Callable[[str], str]


class Checks(Types):
    def __init__(self, model: Model, layout: Layout) -> None:
        super().__init__(model, layout)
        self._checked: set[str] = set()  # structs that can have values that must not be sent
        self._find_checked()

    def _find_checked(self) -> None:
        """Fills `_checked`: first with the structs whose own members need checks, then with the
        structs that contain these, and so on. Structs may contain each other."""
        generated = {
            name: struct.fields
            for name, struct in self.layout.structs.items()
            if names.hand_written(self.model.find(name)) is None
        }
        while found := {name for name, fields in generated.items() if self.have_checks(fields)}:
            self._checked |= found
            generated = {n: fields for n, fields in generated.items() if n not in found}

    def have_checks(self, fields: tuple[FieldLayout, ...]) -> bool:
        """Returns whether `fields` can have values that must not be sent."""
        return any(self._has_checks(field.node) for field in fields)

    def _has_checks(self, node: Node) -> bool:
        match node:
            case ScalarNode(limits=limits):
                return limits is not None
            case StringNode() | UnionNode() | ObjectNode():
                return True
            case MapNode(key, value, bound):
                return bound is not None or self._has_checks(key) or self._has_checks(value)
            case EnumNode(name):
                return isinstance(self.model.find(name), Bitset)
            case StructNode(name) | AppendableNode(name):
                return name in self._checked
            case SequenceNode(element, bound):
                return bound is not None or self._has_checks(element)
            case ArrayNode(element=element) | OptionalNode(element):
                return self._has_checks(element)

    def check(self, slot: Slot, local: Locals, refuse: Refuse = lambda text: text) -> list[str]:
        """Returns statements that return `refuse(reason)` if the value of the slot must not be
        sent."""
        return self._refused(self._check(slot.node, slot.expression, slot.label, local), refuse)

    @staticmethod
    def _refused(lines: list[str], refuse: Refuse) -> list[str]:
        return [
            f"{head}return {refuse(rest.removesuffix(';'))};" if found else line
            for line in lines
            for head, found, rest in [line.partition("return ")]
        ]

    def _check(
        self, node: Node, x: str, label: str, local: Locals, inner: bool = False
    ) -> list[str]:
        """Returns statements that check the value `x`. `inner` tells that `x` is itself an element.
        A message about an element of `x` then needs more than one index."""
        match node:
            case ScalarNode():
                return self._check_number(node, x, label)
            case OptionalNode(element):
                lines = self._check(element, f"*{x}", label, local, inner)
                return block(f"if ({x})", lines) if lines else []
            case StringNode(bound):
                head = f"if (!gecos::wire::valid_text({x}))"
                bad = f"return gecos::wire::bad_text({quoted(label)});"
                short = len(head) + len(bad) < 90
                lines = [f"{head} {bad}"] if short else block(head, [bad])
                return self._over(x, label, bound, "bytes") + lines
            case SequenceNode(element, bound):
                over = self._over(x, label, bound, "elements")
                return over + self._check_elements(element, 1, x, label, local, inner)
            case ArrayNode(element, dimensions):
                return self._check_elements(element, len(dimensions), x, label, local, inner)
            case MapNode(key, value, bound):
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                checks = [
                    *self._check(key, key_name, label, local, True),
                    *self._check(value, value_name, label, local, True),
                ]
                head = f"for (const auto& [{key_name}, {value_name}] : {x})"
                lines = block(head, checks) if checks else []
                return self._over(x, label, bound, "entries") + lines
            case EnumNode(name) | StructNode(name) | AppendableNode(name) | UnionNode(name):
                return self._violation(node, name, x, local)
            case ObjectNode(interface):
                return self._violation(node, interface, x, local)

    def _check_elements(
        self, element: Node, depth: int, x: str, label: str, local: Locals, inner: bool
    ) -> list[str]:
        if depth == 1 and isinstance(element, ScalarNode) and is_bulk(element):
            return self._check_numbers(element, x, label, local, inner)
        item = local.fresh("item" if depth == 1 else "row")
        if depth == 1:
            lines = self._check(element, item, label, local, True)
        else:
            lines = self._check_elements(element, depth - 1, item, label, local, True)
        return loop(item, x, lines)

    def _violation(self, node: Node, name: str, x: str, local: Locals) -> list[str]:
        if not self._has_checks(node):
            return []
        why, violation = local.fresh("why"), self.function(name, "gecos_violation")
        return [f"if (auto {why} = {violation}({x}); !{why}.empty()) return {why};"]

    @staticmethod
    def _check_number(number: ScalarNode, x: str, label: str) -> list[str]:
        if number.limits is None:
            return []
        told = call("gecos::wire::out_of_range", quoted(label), x, limits_text(number))
        return block(f"if (!{range_test(x, number)})", [f"return {told};"])

    @staticmethod
    def _check_numbers(
        number: ScalarNode, x: str, label: str, local: Locals, inner: bool
    ) -> list[str]:
        if number.limits is None:
            return []
        found = local.fresh("outlier")
        first = call("gecos::wire::first_outside", x, bounds(number))
        where = [quoted(label), f"*{found}"] if inner else [quoted(label), x, found]
        function = "out_of_range" if inner else "element_out_of_range"
        told = call(f"gecos::wire::{function}", *where, limits_text(number))
        return block(f"if (const auto* {found} = {first})", [f"return {told};"])

    @staticmethod
    def _over(x: str, label: str, bound: int | None, what: str) -> list[str]:
        if bound is None:
            return []
        size = of(x, "size()")
        told = call("gecos::wire::over_bound", quoted(label), size, str(bound), quoted(what))
        return block(
            f"if ({size} > {bound})",
            [f"return {told};"],
        )
