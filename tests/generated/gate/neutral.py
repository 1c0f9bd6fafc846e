"""Values of interface types that belong to no language, and may be such that must not be sent.

    numbers, enumerators, flags       int or float; characters and booleans too
    string                            bytes of UTF-8, or of what is none
    sequence, array                   list; arrays of several dimensions nested
    map                               list of [key, value]
    struct, exception                 list of the members, those of the bases first
    @optional                         [] or [value]
    union                             [tag, index of the arm that is held (0: none), [value] or []]
    bitset                            list of the named fields, those of the bases first
    object                            [name, interface hash, boot, where]

`raw` writes them as the gate's C++ program reads them.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gidl.model import (
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    Interface,
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
)

CODES = {
    Primitive.BOOLEAN: "B", Primitive.OCTET: "B", Primitive.INT8: "b", Primitive.UINT8: "B",
    Primitive.INT16: "h", Primitive.UINT16: "H", Primitive.INT32: "i", Primitive.UINT32: "I",
    Primitive.INT64: "q", Primitive.UINT64: "Q", Primitive.FLOAT: "f", Primitive.DOUBLE: "d",
    Primitive.CHAR: "B",
}  # fmt: skip
TEXT = StringType()
U64 = PrimitiveType(Primitive.UINT64)


@dataclass(frozen=True)
class Slot:
    """A place for a value: a member, parameter, result or element, with what is said of it."""

    type: Type
    range: Range | None = None
    optional: bool = False
    secret: bool = False


REFERENCE = (Slot(TEXT), Slot(U64), Slot(U64), Slot(TEXT))


def settled(model: Model, slot: Slot) -> Slot:
    """`slot` with the typedefs at its top followed: their ranges hold as well as its own."""
    used, limits = slot.type, slot.range
    while isinstance(used, NamedType):
        declaration = model.find(used.name)
        if not isinstance(declaration, Typedef):
            break
        used, limits = declaration.type, narrowed(limits, declaration.range)
    return Slot(used, limits, slot.optional, slot.secret)


def narrowed(one: Range | None, other: Range | None) -> Range | None:
    if one is None or other is None:
        return one or other
    lows = [r.minimum for r in (one, other) if r.minimum is not None]
    highs = [r.maximum for r in (one, other) if r.maximum is not None]
    return Range(max(lows, default=None), min(highs, default=None))


def element(slot: Slot) -> Slot:
    """The elements of a settled array or sequence: its range speaks of them."""
    assert isinstance(slot.type, SequenceType | ArrayType)
    if isinstance(slot.type, ArrayType) and len(slot.type.dimensions) > 1:
        return Slot(ArrayType(slot.type.element, slot.type.dimensions[1:]), slot.range)
    return Slot(slot.type.element, slot.range)


def members(model: Model, kind: Struct) -> list[Slot]:
    return [Slot(m.type, m.range, m.optional, m.secret) for m in model.all_members(kind)]


def arms(union: Union) -> list[Slot]:
    return [Slot(c.member.type, c.member.range, False, c.member.secret) for c in union.cases]


def named_fields(model: Model, bitset: Bitset) -> list[Any]:
    return [field for field in model.all_fields(bitset) if field.name is not None]


def is_hand_written(declaration: Any) -> bool:
    return isinstance(declaration, Struct) and declaration.maps_to is not None


def chosen(model: Model, union: Union, tag: int) -> int:
    """Index of the arm that `tag` selects; 0 for none."""
    for index, case in enumerate(union.cases, start=1):
        if any(number_of(model, union, label) == tag for label in case.labels):
            return index
    return next((i for i, case in enumerate(union.cases, start=1) if case.is_default), 0)


def number_of(model: Model, union: Union, label: Any) -> int:
    """A label as a number: of a character its code, of an enumerator its number."""
    if isinstance(label, bool | int):
        return int(label)
    if isinstance(label, str):
        return ord(label)
    assert isinstance(union.discriminator, NamedType)
    declaration = model.find(union.discriminator.name)
    if isinstance(declaration, EnumDeclaration):
        return next(e.number for e in declaration.enumerators if e.name == label.literal)
    raise AssertionError(label)


def entries(value: list[Any]) -> list[tuple[Any, Any]]:
    """Entries of a map, each key once, in ascending order: numbers by size, texts by bytes."""
    return sorted(dict(value).items(), key=lambda entry: entry[0])


def has_nan(value: Any) -> bool:
    """A NaN may change its bits on the way through a double."""
    if isinstance(value, list):
        return any(has_nan(item) for item in value)
    return isinstance(value, float) and value != value


def raw(model: Model, slot: Slot, value: Any) -> bytes:
    return b"".join(_raw(model, slot, value))


def _list(items: list[Any]) -> bytes:
    return struct.pack("<I", len(items))


def _raw(model: Model, slot: Slot, value: Any) -> Iterator[bytes]:
    slot = settled(model, slot)
    if slot.optional:
        yield bytes([len(value)])
        for held in value:
            yield from _raw(model, Slot(slot.type, slot.range), held)
        return
    match slot.type:
        case PrimitiveType(kind):
            yield struct.pack("<" + CODES[kind], value)
        case StringType():
            yield struct.pack("<I", len(value)) + value
        case SequenceType():
            yield _list(value)
            for item in value:
                yield from _raw(model, element(slot), item)
        case ArrayType():
            for item in value:
                yield from _raw(model, element(slot), item)
        case MapType(key, item):
            yield _list(entries(value))
            for k, v in entries(value):
                yield from _raw(model, Slot(key), k)
                yield from _raw(model, Slot(item), v)
        case NamedType(name):
            yield from _raw_named(model, name, value)


def _raw_named(model: Model, name: str, value: Any) -> Iterator[bytes]:
    declaration = model.find(name)
    match declaration:
        case Interface():
            for slot, item in zip(REFERENCE, value, strict=True):
                yield from _raw(model, slot, item)
        case EnumDeclaration() | Bitmask():
            yield struct.pack("<Q", value & 0xFFFF_FFFF_FFFF_FFFF)
        case Bitset():
            for field, number in zip(named_fields(model, declaration), value, strict=True):
                yield struct.pack("<" + CODES[field.type.kind], number)
        case Struct() if is_hand_written(declaration):
            yield struct.pack("<I", len(value)) + value
        case Struct():
            for slot, item in zip(members(model, declaration), value, strict=True):
                yield from _raw(model, slot, item)
        case Union():
            tag, index, held = value
            yield from _raw(model, Slot(declaration.discriminator), tag)
            yield struct.pack("<I", index)
            for item in held:
                yield from _raw(model, arms(declaration)[index - 1], item)
