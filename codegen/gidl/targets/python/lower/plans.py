"""How a struct describes itself to gecos.wire.plans, which does its codec in one go."""

from __future__ import annotations

from gidl.model import (
    ArrayType,
    EnumDeclaration,
    ExceptionStruct,
    Member,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    Struct,
    Type,
)
from gidl.targets.python import names
from gidl.targets.python.lower.runs import Runs
from gidl.targets.python.lower.types import CODES, Slot, is_octet, most
from gidl.targets.reach import type_reaches
from gidl.wire_layout import min_size_of, node_of
from gidl.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    Node,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
)


class Plans(Runs):
    def plan(self, struct: Struct) -> list[str] | None:
        """The steps of its members, codes of numbers that follow each other in one; None for a
        struct whose codec is Python's alone: an exception, one that holds itself, or one with a
        member that plans do not know."""
        members = self.model.all_members(struct)
        if isinstance(struct, ExceptionStruct) or names.mapped(struct) or not members:
            return None
        if struct.name not in self.layout.structs:
            return None
        if type_reaches(self.model, struct.name, struct.name):
            return None
        steps: list[str] = []
        for member in members:
            step = self._step_of(struct, member)
            if step is None:
                return None
            if step.startswith('"') and steps and steps[-1].startswith('"'):
                steps[-1] = steps[-1][:-1] + step[1:]
            else:
                steps.append(step)
        return steps

    def _step_of(self, struct: Struct, member: Member) -> str | None:
        slot = Slot("", "", member.type, member.optional, member.range)
        step = self._step(struct, member.type, self.limits(slot))
        return f"_plans.optional({step})" if step is not None and member.optional else step

    def _step(self, owner: Struct, used: Type, limits: Range | None) -> str | None:
        node = node_of(self.model, used)
        target = self.model.target(used)
        match node:
            case ScalarNode(primitive):
                return self._number(primitive, limits)
            case EnumNode(name, wire):
                declaration = self.model.find(name)
                if not isinstance(declaration, EnumDeclaration):
                    return None
                kind = names.type_name(self.model, name)
                literal = declaration.default_literal
                default = "" if literal is None else f", {kind}.{names.enumerator(literal)}"
                return f'_plans.enumerator("{CODES[wire]}", {kind}{default})'
            case StringNode(bound):
                return f"_plans.text({most(bound, 'string')})"
            case StructNode(name):
                return self._nested(owner, name, "struct")
            case AppendableNode(name):
                return self._nested(owner, name, "block")
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                limit = most(bound, "count")
                if is_octet(element):
                    return f"_plans.octets({limit})"
                return self._several(owner, element, target.element, (), limit)
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                if is_octet(element) and len(dimensions) == 1:
                    return f"_plans.fixed_octets({dimensions[0]})"
                return self._several(owner, element, target.element, dimensions, "")
            case _:
                return None

    def _number(self, primitive: Primitive, limits: Range | None) -> str | None:
        if primitive is Primitive.CHAR:
            return None
        code = CODES[primitive]
        if not self._outside("x", PrimitiveType(primitive), limits):
            return f'"{code}"'
        assert limits is not None
        if code == "Q":
            return None
        return f'_plans.ranged("{code}", {limits.minimum}, {limits.maximum})'

    def _nested(self, owner: Struct, name: str, how: str) -> str | None:
        struct = self.model.find(name)
        if not isinstance(struct, Struct) or self.plan(struct) is None:
            return None
        here, there = owner.facts.location, struct.facts.location
        if here.file == there.file and (there.line, there.column) > (here.line, here.column):
            return None  # Python does not know it yet
        return f"_plans.{how}({names.type_name(self.model, name)})"

    def _several(
        self, owner: Struct, element: Node, used: Type, dimensions: tuple[int, ...], limit: str
    ) -> str | None:
        """Elements of an array, or without dimensions of a sequence."""
        limits = self.limits(Slot("", "", used))
        code = self.bulk_code(element)
        if code is not None:
            if limits is not None and code != "d":
                return None
            bounds = "" if limits is None else f", low={limits.minimum}, high={limits.maximum}"
            sizes = ", ".join(str(size) for size in dimensions)
            how = f'array("{code}", {sizes}' if dimensions else f'numbers("{code}", {limit}'
            return f"_plans.{how}{bounds})"
        least = min_size_of(self.model, element)
        step = self._step(owner, used, limits)
        if step is None or least == 0:
            return None
        if not dimensions:
            return f"_plans.items({step}, {least}, {limit})"
        for size in reversed(dimensions):
            step = f"_plans.fixed_items({step}, {least}, {size})"
            least *= size
        return step
