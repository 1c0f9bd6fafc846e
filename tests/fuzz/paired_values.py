"""Random values, each made twice: as generated Python has it and as lcm-gen's Python has it.

Neither is made out of the other's bytes, so that what both encode can be compared.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from random import Random
from typing import Any

import numpy as np
from gidl.model import (
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    EnumValue,
    MapType,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    within,
)
from gidl.targets.python import names
from gidl.wire.lcm_lowering import LcmMember, LcmStruct, Lowering
from gidl.wire.wire_layout import Layout, node_of
from gidl.wire.wire_nodes import AppendableNode, UnionNode

Pair = tuple[Any, Any]
DTYPES = {
    Primitive.BOOLEAN: "bool", Primitive.OCTET: "uint8",
    Primitive.FLOAT: "float32", Primitive.DOUBLE: "float64",
}  # fmt: skip
DEEPEST = 3  # levels of a type that contains itself
LETTERS = "aZ09 _%äßé€漢\U0001f916\n\x7f"
SPECIAL = (0.0, -0.0, inf, -inf, 5e-324, -1.0, 1.7976931348623157e308)


@dataclass(frozen=True)
class Slot:
    """A place for a value: `lcm` is the type of its LCM member, or of the elements of that."""

    type: Type
    lcm: str
    optional: bool = False
    range: Range | None = None


class PairedValues:
    """Makes values of the types of one model; `ours` and `theirs` find the two classes of a type
    by its scoped name and by its full name in LCM."""

    def __init__(
        self,
        model: Model,
        layout: Layout,
        ours: Callable[[str], Any],
        theirs: Callable[[str], Any],
        dice: Random,
    ) -> None:
        self._model = model
        self._lcm = {s.name: s for of_file in layout.lcm_structs.values() for s in of_file}
        self._lcm_of = {s.source: s for s in self._lcm.values() if s.source is not None}
        self._lowering = Lowering(model, node_of)
        self._ours, self._theirs = ours, theirs
        self._dice = dice
        self._open: list[str] = []
        self._slots: dict[str, list[tuple[str, LcmMember, LcmMember | None, Slot]]] = {}

    def struct(self, name: str) -> Pair:
        """A value of a struct: its own members, without regard to how it lies in others."""
        lcm = self._lcm_of[name]
        theirs = self._theirs(lcm.name)()
        arguments = {}
        self._open.append(name)
        for python_name, member, count, slot in self._slots_of(name, lcm):
            arguments[python_name], value = self._member(slot)
            _put(theirs, member, count, value)
        self._open.pop()
        return self._ours(name)(**arguments), theirs

    def _slots_of(
        self, name: str, lcm: LcmStruct
    ) -> list[tuple[str, LcmMember, LcmMember | None, Slot]]:
        if name not in self._slots:
            self._slots[name] = []
            for m in self._model.all_members(self._model.struct(name)):
                member, count = _lcm_member(lcm, m.name)
                slot = Slot(m.type, member.type, m.optional, m.range)
                self._slots[name].append((names.member_name(m.name), member, count, slot))
        return self._slots[name]

    def _union(self, name: str, union: Union) -> Pair:
        lcm = self._lcm_of[name]
        theirs = self._theirs(lcm.name)()
        case = self._dice.choice(union.cases)
        labels = case.labels or (self._unlabelled(union),)
        label = self._dice.choice(labels)
        held = None
        for each in union.cases:
            member, count = _lcm_member(lcm, each.member.name)
            value: list[Any] = []
            if each is case:
                slot = Slot(each.member.type, member.type, range=each.member.range)
                held, their_held = self._element(slot)
                value = [their_held]
            _put(theirs, member, count, bytes(value) if member.type == "byte" else value)
        ours: Any = label
        number = label
        if isinstance(label, EnumValue):
            number = label.number
            ours = self._ours(label.enum)[names.enumerator(label.literal)]
        elif isinstance(label, str):
            number = ord(label)
        assert not isinstance(number, str | EnumValue)
        tag = lcm.members[0]
        setattr(theirs, tag.name, _signed(int(number), 64 if tag.type == "int64_t" else 32))
        return self._ours(name)(ours, held), theirs

    def _unlabelled(self, union: Union) -> Any:
        """A value of the discriminator that no case names."""
        if isinstance(union.discriminator, NamedType):
            enum = self._model.find(union.discriminator.name)
            assert isinstance(enum, EnumDeclaration)
            taken = {label for case in union.cases for label in case.labels}
            values = [EnumValue(enum.name, e.name, e.number) for e in enum.enumerators]
            return self._dice.choice([value for value in values if value not in taken])
        return "q" if union.discriminator.kind is Primitive.CHAR else 42

    # A value as a member is the same as one within a sequence, unless LCM has to wrap it there.

    def _member(self, slot: Slot) -> Pair:
        if slot.optional:
            if self._dice.random() < 0.4:
                return None, b"" if slot.lcm == "byte" else []
            ours, theirs = self._element(Slot(slot.type, slot.lcm, False, slot.range))
            return ours, bytes([theirs]) if slot.lcm == "byte" else [theirs]
        used, limits = self._target(slot)
        match used:
            case PrimitiveType(kind):
                return self._scalar(kind, limits)
            case StringType(bound):
                text = self._text(bound)
                return text, text
            case SequenceType(element, bound):
                size = self._size(bound, element)
                return self._list(Slot(element, slot.lcm, range=limits), size)
            case ArrayType(element, dimensions):
                return self._array(Slot(element, slot.lcm, range=limits), dimensions)
            case MapType(key, value, bound):
                return self._map(slot.lcm, key, value, self._size(bound, value))
            case NamedType(name):
                return self._named(name)

    def _element(self, slot: Slot) -> Pair:
        if self._lowering.simple_type(node_of(self._model, slot.type)) is not None:
            return self._member(slot)
        helper = self._lcm[slot.lcm]
        theirs = self._theirs(helper.name)()
        member, count = _lcm_member(helper, "value")
        ours, value = self._member(Slot(slot.type, member.type, range=slot.range))
        _put(theirs, member, count, value)
        return ours, theirs

    def _target(self, slot: Slot) -> tuple[Type, Range | None]:
        used, limits = slot.type, slot.range
        while isinstance(used, NamedType):
            declaration = self._model.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            used, limits = declaration.type, within(limits, declaration.range)
        return used, limits

    def _named(self, name: str) -> Pair:
        declaration = self._model.find(name)
        match declaration:
            case EnumDeclaration():
                chosen = self._dice.choice(declaration.enumerators)
                return self._ours(name)[names.enumerator(chosen.name)], chosen.number
            case Bitmask(bit_bound=bits):
                number = self._dice.getrandbits(bits)
                for flag in declaration.flags:  # unnamed bits within the bound may be set too
                    number |= self._dice.getrandbits(1) << flag.position
                return self._ours(name)(number), _signed(number, 64 if bits > 32 else 32)
            case Bitset(bit_size=bits):
                return self._bitset(declaration, 64 if bits > 32 else 32)
            case Struct() | Union():
                if isinstance(declaration, Union):
                    ours, theirs = self._union(name, declaration)
                else:
                    ours, theirs = self.struct(name)
                node = node_of(self._model, NamedType(name))
                block = isinstance(node, AppendableNode)
                block = block or (isinstance(node, UnionNode) and node.appendable)
                return ours, theirs.encode()[8:] if block else theirs
        raise AssertionError(name)

    def _bitset(self, bitset: Bitset, width: int) -> Pair:
        fields: dict[str, Any] = {}
        bits = 0
        for each in self._model.all_fields(bitset):
            if each.name is None:
                continue
            raw = self._dice.getrandbits(each.width)
            bits |= raw << each.position
            value: int | bool = raw
            if each.type.kind is Primitive.BOOLEAN:
                value = bool(raw)
            elif not each.type.kind.is_unsigned:
                value = _signed(raw, each.width)
            fields[names.member_name(each.name)] = value
        return self._ours(bitset.name)(**fields), _signed(bits, width)

    def _list(self, slot: Slot, size: int) -> Pair:
        pairs = [self._element(slot) for _ in range(size)]
        kind = self._model.target(slot.type)
        return _collected(kind, pairs, (size,)), _their_list(slot.lcm, [p[1] for p in pairs])

    def _array(self, slot: Slot, dimensions: tuple[int, ...]) -> Pair:
        count = int(np.prod(dimensions))
        pairs = [self._element(slot) for _ in range(count)]
        theirs = [pair[1] for pair in pairs]
        for size in reversed(dimensions[1:]):
            theirs = [theirs[i : i + size] for i in range(0, len(theirs), size)]
        if slot.lcm == "byte":
            theirs = _bytes_innermost(theirs, len(dimensions))
        return _collected(self._model.target(slot.type), pairs, dimensions), theirs

    def _map(self, entry: str, key: Type, value: Type, size: int) -> Pair:
        lcm = self._lcm[entry]
        keys = {}
        for _ in range(size):
            ours, theirs = self._member(Slot(key, _lcm_member(lcm, "key")[0].type))
            keys[theirs] = ours
        pairs = {}
        for their_key in keys:
            held, count = _lcm_member(lcm, "value")
            pairs[their_key] = self._member(Slot(value, held.type))
        # Unsigned keys ascend as the numbers they are, not as the bits that LCM sees; text ascends
        # by its bytes.
        entries = []
        for their_key in sorted(keys, key=lambda k: _order(keys[k])):
            made = self._theirs(entry)()
            setattr(made, _lcm_member(lcm, "key")[0].name, their_key)
            held, count = _lcm_member(lcm, "value")
            _put(made, held, count, pairs[their_key][1])
            entries.append(made)
        return {ours: pairs[theirs][0] for theirs, ours in keys.items()}, entries

    def _size(self, bound: int | None, element: Type) -> int:
        target = self._model.target(element)
        if isinstance(target, NamedType) and self._open.count(target.name) >= DEEPEST:
            return 0
        most = 20 if isinstance(target, PrimitiveType) and self._dice.random() < 0.2 else 3
        return self._dice.randint(0, most if bound is None else min(bound, most))

    def _text(self, bound: int | None) -> str:
        text = "".join(self._dice.choices(LETTERS, k=self._dice.randint(0, 9)))
        while bound is not None and len(text.encode()) > bound:
            text = text[:-1]
        return text

    def _scalar(self, kind: Primitive, limits: Range | None) -> Pair:
        dice = self._dice
        match kind:
            case Primitive.BOOLEAN:
                flag = dice.random() < 0.5
                return flag, flag
            case Primitive.CHAR:
                code = dice.randrange(256)
                return chr(code), _signed(code, 8)
            case Primitive.FLOAT | Primitive.DOUBLE:
                number = self._real(kind, limits)
                return number, number
        low, high = kind.integer_limits
        if limits is not None:
            low = low if limits.minimum is None else max(low, int(limits.minimum))
            high = high if limits.maximum is None else min(high, int(limits.maximum))
        value = dice.choice((low, high, dice.randint(low, high), dice.randint(low, high)))
        return value, value if kind is Primitive.OCTET else _signed(value, 8 * kind.size)

    def _real(self, kind: Primitive, limits: Range | None) -> float:
        code, size = ("f", 4) if kind is Primitive.FLOAT else ("d", 8)
        if limits is not None:
            assert limits.minimum is not None and limits.maximum is not None
            number = self._dice.uniform(limits.minimum, limits.maximum)
        elif self._dice.random() < 0.1:
            number = self._dice.choice(SPECIAL)
            number = number if code == "d" or abs(number) < 2 or number in (inf, -inf) else 2.0
        else:
            number = float("nan")
            while number != number:
                number = struct.unpack(f">{code}", self._dice.randbytes(size))[0]
        rounded: float = struct.unpack(f">{code}", struct.pack(f">{code}", number))[0]
        return rounded


def _lcm_member(lcm: LcmStruct, source: str) -> tuple[LcmMember, LcmMember | None]:
    """The member that a member of the interface became, and its count where it has one."""
    member = next(m for m in lcm.members if m.source == source)
    for dimension in member.dimensions:
        if dimension.variable:
            return member, next(m for m in lcm.members if m.name == dimension.size)
    return member, None


def _put(theirs: Any, member: LcmMember, count: LcmMember | None, value: Any) -> None:
    setattr(theirs, member.name, value)
    if count is not None:
        setattr(theirs, count.name, len(value))


def _their_list(lcm: str, items: list[Any]) -> Any:
    return bytes(items) if lcm == "byte" else items


def _bytes_innermost(items: Any, depth: int) -> Any:
    return bytes(items) if depth == 1 else [_bytes_innermost(each, depth - 1) for each in items]


def _collected(element: Type, pairs: list[Pair], shape: tuple[int, ...]) -> Any:
    """What generated Python keeps many values in."""
    ours = [pair[0] for pair in pairs]
    if isinstance(element, PrimitiveType) and element.kind is not Primitive.CHAR:
        if element.kind is Primitive.OCTET and len(shape) == 1:
            return bytes(ours)
        return np.array(ours, DTYPES.get(element.kind, element.kind.value)).reshape(shape)
    for size in reversed(shape[1:]):
        ours = [ours[i : i + size] for i in range(0, len(ours), size)]
    return ours


def _order(key: Any) -> Any:
    return key.encode() if isinstance(key, str) else key


def _signed(bits: int, width: int) -> int:
    bits &= (1 << width) - 1
    return bits - (1 << width) if bits >> (width - 1) else bits
