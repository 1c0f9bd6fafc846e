"""Runs: fixed-size numbers that follow each other, nested structs opened up, as one `struct`."""

from __future__ import annotations

from dataclasses import dataclass, field

from gidl.model import (
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    Interface,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    Struct,
    Type,
    Typedef,
)
from gidl.targets.naming import range_text
from gidl.targets.python import names
from gidl.targets.python.lower.types import CODES, SIZES, Slot, Types
from gidl.wire_layout import node_of
from gidl.wire_nodes import (
    EnumNode,
    ScalarNode,
    StructNode,
)


@dataclass(slots=True)
class Leaf:
    """One number of a run."""

    code: str
    access: str
    label: str
    type: Type
    limits: Range | None


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
        if slot.optional:
            return None
        node = node_of(self.model, slot.type)
        match node:
            case ScalarNode(Primitive.CHAR):
                return None
            case ScalarNode(primitive):
                limits = self.limits(slot)
                return [Leaf(CODES[primitive], slot.expression, slot.label, slot.type, limits)]
            case EnumNode(name, wire):
                if isinstance(self.model.find(name), Bitset):
                    return None
                signed = isinstance(self.model.find(name), EnumDeclaration)
                code = CODES[wire] if signed else CODES[wire].upper()
                return [Leaf(code, slot.expression, slot.label, slot.type, None)]
            case StructNode(name):
                struct = self.model.struct(name)
                if names.mapped(struct) or not self.model.all_members(struct):
                    return None
                found: list[Leaf] = []
                for m in self.model.all_members(struct):
                    inner = Slot(
                        f"{slot.expression}.{names.member_name(m.name, self.words(struct))}",
                        f"{struct.simple_name}.{m.name}", m.type, m.optional, m.range,
                    )  # fmt: skip
                    more = self.leaves(inner)
                    if more is None:
                        return None
                    found += more
                return found
            case _:
                return None

    def expected(self, slot: Slot) -> list[str]:
        """Statements before a value's numbers are packed: the structs among them are what they
        should be."""
        node = node_of(self.model, slot.type)
        if not isinstance(node, StructNode):
            return []
        struct = self.model.struct(node.name)
        kind = names.type_name(self.model, node.name)
        lines = [f'_wire.expect({slot.expression}, {kind}, "{slot.label}")']
        for m in self.model.all_members(struct):
            expression = f"{slot.expression}.{names.member_name(m.name, self.words(struct))}"
            lines += self.expected(Slot(expression, f"{struct.simple_name}.{m.name}", m.type))
        return lines

    def rebuilt(self, used: Type, variables: list[str], behind: list[int], label: str) -> str:
        """The value made of the next variables of a run, which are taken from the lists."""
        node = node_of(self.model, used)
        match node:
            case StructNode(name):
                struct = self.model.struct(name)
                parts = [
                    self.rebuilt(m.type, variables, behind, f"{struct.simple_name}.{m.name}")
                    for m in self.model.all_members(struct)
                ]
                return f"{names.type_name(self.model, name)}({', '.join(parts)})"
            case EnumNode(name):
                return self._enumerator(name, variables.pop(0), label, behind.pop(0))
            case _:
                behind.pop(0)
                return variables.pop(0)

    def _enumerator(self, name: str, number: str, label: str, behind: int) -> str:
        declaration = self.model.find(name)
        mine = names.type_name(self.model, name)
        if isinstance(declaration, Bitmask):
            return f'source.flags({mine}, {number}, {declaration.bit_bound}, "{label}", {behind})'
        assert isinstance(declaration, EnumDeclaration)
        default = "None"
        if declaration.default_literal is not None:
            default = f"{mine}.{names.enumerator(declaration.default_literal)}"
        return f'source.enumerator({mine}, {number}, {default}, "{label}", {behind})'

    def check_leaf(self, leaf: Leaf) -> list[str]:
        """Statements after a number was packed."""
        test = self._outside(leaf.access, leaf.type, leaf.limits)
        if test:
            assert leaf.limits is not None
            text = range_text(leaf.limits)
            return [
                f"if {test}:",
                f'    raise _wire.out_of_range("{leaf.label}", {leaf.access}, "{text}")',
            ]
        target = self.model.target(leaf.type)
        if isinstance(target, NamedType):
            declaration = self.model.find(target.name)
            if isinstance(declaration, EnumDeclaration):
                kind = names.type_name(self.model, target.name)
                return [f'_wire.expect_enumerator({leaf.access}, {kind}, "{leaf.label}")']
            if isinstance(declaration, Bitmask) and declaration.bit_bound not in (32, 64):
                most = (1 << declaration.bit_bound) - 1
                return [
                    f"if {leaf.access} > {most}:",
                    f'    raise _wire.out_of_range("{leaf.label}", {leaf.access}, "[0, {most}]")',
                ]
        return []

    def refuse_leaf(self, leaf: Leaf, variable: str, behind: int) -> list[str]:
        """Statements after a number was read."""
        test = self._outside(variable, leaf.type, leaf.limits, read=True)
        if not test:
            return []
        return [f"if {test}:", f'    source.refuse_range("{leaf.label}", {behind})']

    def _outside(self, x: str, used: Type, limits: Range | None, read: bool = False) -> str:
        target = self.model.target(used)
        if limits is None or not isinstance(target, PrimitiveType):
            return ""
        lower, upper = limits.minimum, limits.maximum
        if target.kind.is_integer:
            least, most = target.kind.integer_limits
            lower = None if lower is not None and lower <= least else lower
            upper = None if upper is not None and upper >= most else upper
        single = target.kind is Primitive.FLOAT
        lower_text, upper_text = (
            (as_read(lower, single), as_read(upper, single)) if read else (str(lower), str(upper))
        )
        if lower is None and upper is None:
            return ""
        if lower is None:
            return f"not {x} <= {upper_text}"
        if upper is None:
            return f"not {x} >= {lower_text}"
        return f"not {lower_text} <= {x} <= {upper_text}"

    def imports(self, used: Type) -> set[str]:
        """Scoped names of the declared types that a value's codec and hint name."""
        match used:
            case NamedType(name):
                declaration = self.model.find(name)
                if isinstance(declaration, Typedef):
                    return self.imports(declaration.type)
                if isinstance(declaration, Struct) and not names.mapped(declaration):
                    opened = self.leaves(Slot("", "", used))
                    inner: set[str] = {name}
                    if opened:
                        for m in self.model.all_members(declaration):
                            inner |= self.imports(m.type)
                    return inner
                return {names.OBJECT_REF if isinstance(declaration, Interface) else name}
            case SequenceType(element) | ArrayType(element):
                return self.imports(element)
            case MapType(key, value):
                return self.imports(key) | self.imports(value)
            case _:
                return set()


def as_read(value: int | float | None, single: bool) -> str:
    """A bound as readers compare it: that of single precision is rounded like the number."""
    if value is None or not single:
        return str(value)
    import struct

    return repr(struct.unpack("f", struct.pack("f", value))[0])
