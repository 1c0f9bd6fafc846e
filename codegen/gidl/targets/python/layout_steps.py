"""Prints layout steps: arguments for functions of `gecos.wire.layout`, one for each value."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from gidl.model import Model, Primitive, Range
from gidl.targets.groups import call, group
from gidl.targets.python.homes import ModuleNames
from gidl.targets.python.type_text import CODES, Types, bulk_code, is_octet, quoted
from gidl.wire.wire_layout import Layout
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


class Lowering(Types):
    def __init__(self, model: Model, layout: Layout, module: ModuleNames) -> None:
        super().__init__(model, layout, module)
        self.pending: set[str] = set()
        """Names of declarations whose classes are defined later in the module."""

    def steps(self, values: Iterable[tuple[Node, bool]]) -> list[str]:
        """Returns the steps for `values`. Each value is a pair: its node, and True if the value is
        secret. The codes of consecutive numbers are joined into one text."""
        found: list[str] = []
        for node, secret in values:
            step = self.step(node, secret)
            if step.startswith('"') and found and found[-1].startswith('"'):
                found[-1] = found[-1][:-1] + step[1:]
            else:
                found.append(step)
        return found

    def step(self, node: Node, secret: bool = False) -> str:
        text = self._step(node)
        return call("_layout.secret", text) if secret else text

    def _step(self, node: Node) -> str:
        match node:
            case OptionalNode(element):
                return call("_layout.optional", self._step(element))
            case ScalarNode(Primitive.CHAR):
                return "_layout.char()"
            case ScalarNode(primitive, limits):
                code = quoted(CODES[primitive])
                if limits is None or node.bounds is None:
                    return code
                high = [] if limits.maximum is None else [_limit(limits.maximum)]
                return call("_layout.ranged", code, _limit(limits.minimum), *high, *_unit(node))
            case StringNode(bound):
                return call("_layout.text", *_bound(bound))
            case SequenceNode(element, bound):
                return self._sequence(element, _bound(bound))
            case ArrayNode(element, dimensions):
                return self._array(element, dimensions)
            case MapNode(key, value, bound):
                return call("_layout.mapping", self._step(key), self._step(value), *_bound(bound))
            case (
                EnumNode(name)
                | StructNode(name)
                | AppendableNode(name)
                | UnionNode(name)
                | ObjectNode(name)
            ):
                kind = self.module.value(name)
                return f"lambda: {kind}" if name in self.pending else kind

    def _sequence(self, element: Node, bound: list[str]) -> str:
        if is_octet(element):
            return call("_layout.octets", *bound, *_limits(element))
        code = bulk_code(element)
        if code is not None:
            return call("_layout.numbers", quoted(code), *bound, *_limits(element))
        return call("_layout.items", self._step(element), *bound)

    def _array(self, element: Node, dimensions: Sequence[int]) -> str:
        sizes = [str(size) for size in dimensions]
        if is_octet(element) and len(sizes) == 1:
            return call("_layout.fixed_octets", *sizes, *_limits(element))
        code = bulk_code(element)
        if code is not None:
            return call("_layout.array", quoted(code), *sizes, *_limits(element))
        text = self._step(element)
        for size in reversed(sizes):
            text = call("_layout.fixed_items", text, size)
        return text


def renamed(names: Iterable[tuple[str, str]]) -> list[str]:
    """Returns the argument `names` of a layout. The argument maps the Python name of a member to
    its name in the interface, for each member whose names differ. The list is empty if no names
    differ."""
    pairs = [f"{quoted(here)}: {quoted(there)}" for here, there in names if here != there]
    return [f"names={group(pairs, '{', '}')}"] if pairs else []


def units_of(units: Iterable[tuple[str, str | None]]) -> list[str]:
    """Returns the keyword argument `units` of an exception. The argument maps the names of members,
    as in the interface, to their units. If no member has a unit, the list is empty."""
    pairs = [f"{quoted(name)}: {quoted(unit)}" for name, unit in units if unit]
    return [f"units={group(pairs, '{', '}')}"] if pairs else []


def _bound(bound: int | None) -> list[str]:
    return [] if bound is None else [str(bound)]


def _limit(value: int | float | None) -> str:
    return repr(value)


def _limits(element: Node) -> list[str]:
    if not isinstance(element, ScalarNode) or element.limits is None:
        return []
    limits: Range = element.limits
    sides = (("low", limits.minimum), ("high", limits.maximum))
    given = [f"{name}={_limit(value)}" for name, value in sides if value is not None]
    return given + _unit(element)


def _unit(number: ScalarNode) -> list[str]:
    return [f"unit={quoted(number.unit)}"] if number.unit else []
