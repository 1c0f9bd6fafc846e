"""How a struct describes itself to gecos.wire.plans, which does its codec in one go."""

from __future__ import annotations

from collections.abc import Sequence

from gidl.model import EnumDeclaration, ExceptionStruct, Primitive, Struct
from gidl.targets.groups import call
from gidl.targets.python import names
from gidl.targets.python.homes import AllNames
from gidl.targets.python.lower.reading import range_arguments
from gidl.targets.python.lower.runs import Runs
from gidl.targets.python.lower.types import CODES, bulk_code, is_octet, most, quoted, sent_bounds
from gidl.targets.reach import type_reaches
from gidl.wire_layout import min_size_of
from gidl.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    Node,
    OptionalNode,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
)

_LIMITED = frozenset("d")  # codes of the numbers whose arrays may have limits in a plan


class Plans(Runs):
    def plan(self, struct: Struct) -> list[str] | None:
        """The steps of its members, codes of numbers that follow each other in one; None for a
        struct whose codec is Python's alone: an exception, one that holds itself, or one with a
        member that plans do not know."""
        if isinstance(struct, ExceptionStruct) or names.mapped(struct):
            return None
        if type_reaches(self.model, struct.name, struct.name):
            return None
        steps: list[str] = []
        for field in self.fields(struct):
            step = self._step(struct, field.node)
            if step is None:
                return None
            if step.startswith('"') and steps and steps[-1].startswith('"'):
                steps[-1] = steps[-1][:-1] + step[1:]
            else:
                steps.append(step)
        return steps or None

    def _step(self, owner: Struct, node: Node) -> str | None:
        match node:
            case OptionalNode(element):
                step = self._step(owner, element)
                return None if step is None else call("_plans.optional", step)
            case ScalarNode():
                return _number(node)
            case EnumNode(name, wire):
                return self._enumerator_step(name, CODES[wire])
            case StringNode(bound):
                return call("_plans.text", most(bound, "string"))
            case StructNode(name):
                return self._nested(owner, name, "struct")
            case AppendableNode(name):
                return self._nested(owner, name, "block")
            case SequenceNode(element, bound):
                limit = most(bound, "count")
                if is_octet(element):
                    return call("_plans.octets", limit)
                return self._several(owner, element, (), limit)
            case ArrayNode(element, dimensions):
                if is_octet(element) and len(dimensions) == 1:
                    return call("_plans.fixed_octets", str(dimensions[0]))
                return self._several(owner, element, dimensions, "")
            case _:
                return None

    def _enumerator_step(self, name: str, code: str) -> str | None:
        declaration = self.model.find(name)
        if not isinstance(declaration, EnumDeclaration):
            return None
        kind = self.module.value(name)
        literal = declaration.default_literal
        default = [] if literal is None else [f"{kind}.{names.enumerator(literal)}"]
        return call("_plans.enumerator", quoted(code), kind, *default)

    def _nested(self, owner: Struct, name: str, how: str) -> str | None:
        struct = self.model.find(name)
        if not isinstance(struct, Struct) or not self._has_plan(struct):
            return None
        here, there = owner.facts.location, struct.facts.location
        if here.file == there.file and (there.line, there.column) > (here.line, here.column):
            return None  # Python does not know it yet
        return call(f"_plans.{how}", self.module.value(name))

    def _has_plan(self, struct: Struct) -> bool:
        return self.within(AllNames(self.module.homes)).plan(struct) is not None

    def _several(
        self, owner: Struct, element: Node, dimensions: Sequence[int], limit: str
    ) -> str | None:
        """Elements of an array, or without dimensions of a sequence."""
        code = bulk_code(element)
        if code is not None:
            limits = range_arguments(element)
            if limits and code not in _LIMITED:
                return None
            bounds = [f"{name}={x}" for name, x in zip(("low", "high"), limits, strict=False)]
            if dimensions:
                return call("_plans.array", quoted(code), *map(str, dimensions), *bounds)
            return call("_plans.numbers", quoted(code), limit, *bounds)
        least = min_size_of(self.model, element)
        step = self._step(owner, element)
        if step is None or least == 0:
            return None
        if not dimensions:
            return call("_plans.items", step, str(least), limit)
        for size in reversed(dimensions):
            step = call("_plans.fixed_items", step, str(least), str(size))
            least *= size
        return step


def _number(node: ScalarNode) -> str | None:
    if node.primitive is Primitive.CHAR:
        return None
    code = CODES[node.primitive]
    bounds = sent_bounds(node)
    if bounds is None:
        return quoted(code)
    if code == "Q":
        return None
    return call("_plans.ranged", quoted(code), repr(bounds.minimum), repr(bounds.maximum))
