"""Runs: fixed-size numbers that follow each other, nested structs opened up, as one `struct`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from gidl.model import Bitmask, Bitset, EnumDeclaration, Primitive, Range, Struct
from gidl.targets.groups import call
from gidl.targets.naming import range_text
from gidl.targets.python import names
from gidl.targets.python.homes import Home
from gidl.targets.python.lower.types import CODES, SIZES, Slot, Types, quoted, sent_bounds
from gidl.wire_nodes import EnumNode, Node, ScalarNode, StructNode


@dataclass(slots=True)
class Leaf:
    """One number of a run."""

    code: str
    access: str
    label: str
    node: ScalarNode | EnumNode


@dataclass(slots=True)
class Run:
    leaves: list[Leaf] = field(default_factory=list)

    @property
    def size(self) -> int:
        return sum(SIZES[leaf.code] for leaf in self.leaves)

    def behind(self, index: int) -> int:
        """Bytes from the start of a leaf to the end of the run."""
        return sum(SIZES[leaf.code] for leaf in self.leaves[index:])


class Runs(Types):
    def leaves(self, slot: Slot) -> list[Leaf] | None:
        """The numbers a value consists of, when it is nothing but fixed-size numbers."""
        match slot.node:
            case ScalarNode(Primitive.CHAR):
                return None
            case ScalarNode(primitive) as node:
                return [Leaf(CODES[primitive], slot.expression, slot.label, node)]
            case EnumNode(name, wire) as node:
                if isinstance(self.model.find(name), Bitset):
                    return None
                signed = isinstance(self.model.find(name), EnumDeclaration)
                code = CODES[wire] if signed else CODES[wire].upper()
                return [Leaf(code, slot.expression, slot.label, node)]
            case StructNode(name):
                struct = self.model.struct(name)
                if names.mapped(struct) or not self.fields(struct):
                    return None
                found: list[Leaf] = []
                for inner in self.slots(struct, slot.expression):
                    more = self.leaves(inner)
                    if more is None:
                        return None
                    found += more
                return found
            case _:
                return None

    def slots(self, struct: Struct, expression: str) -> Iterator[Slot]:
        """The members of the value that `expression` is."""
        words = self.words(struct)
        for field_ in self.fields(struct):
            access = f"{expression}.{names.member_name(field_.name, words)}"
            yield Slot(access, f"{struct.simple_name}.{field_.name}", field_.node)

    def used(self, node: Node) -> set[Home]:
        """The classes that hint and codec of a member name: where it is numbers alone, also those
        inside."""
        found = self.named(node)
        if isinstance(node, StructNode) and self.leaves(Slot("", "", node)) is not None:
            inside = self.fields(self.model.struct(node.name))
            found = found.union(*(self.used(field_.node) for field_ in inside))
        return found

    def expected(self, slot: Slot) -> list[str]:
        """Statements before a value's numbers are packed: the structs among them are what they
        should be."""
        if not isinstance(slot.node, StructNode):
            return []
        kind = self.module.value(slot.node.name)
        lines = [call("_wire.expect", slot.expression, kind, quoted(slot.label))]
        for inner in self.slots(self.model.struct(slot.node.name), slot.expression):
            lines += self.expected(inner)
        return lines

    def rebuilt(self, node: Node, variables: list[str], behind: list[int], label: str) -> str:
        """The value made of the next variables of a run, which are taken from the lists."""
        match node:
            case StructNode(name):
                inside = self.slots(self.model.struct(name), "")
                parts = [self.rebuilt(s.node, variables, behind, s.label) for s in inside]
                return call(self.module.value(name), *parts)
            case EnumNode(name):
                return self.enumerator(name, variables.pop(0), quoted(label), behind.pop(0))
            case _:
                behind.pop(0)
                return variables.pop(0)

    def enumerator(self, name: str, number: str, label: str, behind: int) -> str:
        """The enumerator or flags of a number that was read; `label` is a literal."""
        declaration = self.model.find(name)
        mine = self.module.value(name)
        if isinstance(declaration, Bitmask):
            bits = str(declaration.bit_bound)
            return call("source.flags", mine, number, bits, label, str(behind))
        assert isinstance(declaration, EnumDeclaration)
        default = "None"
        if declaration.default_literal is not None:
            default = f"{mine}.{names.enumerator(declaration.default_literal)}"
        return call("source.enumerator", mine, number, default, label, str(behind))

    def check_leaf(self, leaf: Leaf) -> list[str]:
        """Statements after a number was packed."""
        if isinstance(leaf.node, ScalarNode):
            bounds, limits = sent_bounds(leaf.node), leaf.node.limits
            if bounds is None or limits is None:
                return []
            return _refused(leaf, _outside(leaf.access, bounds), limits)
        declaration = self.model.find(leaf.node.name)
        if isinstance(declaration, EnumDeclaration):
            kind = self.module.value(declaration.name)
            return [call("_wire.expect_enumerator", leaf.access, kind, quoted(leaf.label))]
        if isinstance(declaration, Bitmask) and declaration.bit_bound not in (32, 64):
            most = (1 << declaration.bit_bound) - 1
            return _refused(leaf, f"{leaf.access} > {most}", Range(0, most))
        return []

    def refuse_leaf(self, leaf: Leaf, variable: str, behind: int) -> list[str]:
        """Statements after a number was read."""
        if not isinstance(leaf.node, ScalarNode) or leaf.node.bounds is None:
            return []
        refuse = call("source.refuse_range", quoted(leaf.label), str(behind))
        return [f"if {_outside(variable, leaf.node.bounds)}:", f"    {refuse}"]


def _refused(leaf: Leaf, test: str, limits: Range) -> list[str]:
    arguments = (quoted(leaf.label), leaf.access, quoted(range_text(limits)))
    return [f"if {test}:", f"    raise {call('_wire.out_of_range', *arguments)}"]


def _outside(x: str, limits: Range) -> str:
    lower, upper = limits.minimum, limits.maximum
    if lower is None:
        return f"not {x} <= {upper!r}"
    if upper is None:
        return f"not {x} >= {lower!r}"
    return f"not {lower!r} <= {x} <= {upper!r}"
