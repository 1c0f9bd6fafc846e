"""The gate's own encoder, which targets are compared with: it encodes any neutral value, and says
what is wrong with one. It takes ranges from the model's annotations alone, so that a target or a
layout that forgets one is noticed."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
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
    SequenceType,
    StringType,
    Struct,
    Union,
)
from neutral import (
    CODES,
    REFERENCE,
    Slot,
    arms,
    chosen,
    element,
    entries,
    is_hand_written,
    members,
    named_fields,
    settled,
)

WRONG_ARM, WRONG_BITS = "wrong arm", "too many bits"


def rounded(number: float) -> float:
    """The nearest float of 32 bits."""
    try:
        return float(struct.unpack("f", struct.pack("f", number))[0])
    except OverflowError:
        return math.copysign(math.inf, number)


class Opinion:
    def __init__(self, model: Model) -> None:
        self._model = model

    # -- bytes ---------------------------------------------------------------------------------

    def encoded(self, slot: Slot, value: Any) -> bytes:
        return b"".join(self._encoded(slot, value))

    def fields(self, slots: list[Slot], values: list[Any]) -> bytes:
        return b"".join(self.encoded(s, v) for s, v in zip(slots, values, strict=True))

    def contents(self, name: str, value: Any) -> bytes:
        """A struct or union without the size that appendable ones have inside others."""
        declaration = self._model.find(name)
        if isinstance(declaration, Union):
            return self._union(declaration, value)
        assert isinstance(declaration, Struct)
        return self.fields(members(self._model, declaration), value)

    def _encoded(self, slot: Slot, value: Any) -> Iterator[bytes]:
        slot = settled(self._model, slot)
        if slot.optional:
            yield bytes([len(value)])
            for held in value:
                yield from self._encoded(Slot(slot.type, slot.range), held)
            return
        match slot.type:
            case PrimitiveType(Primitive.FLOAT):
                yield struct.pack(">f", rounded(value))
            case PrimitiveType(kind):
                yield struct.pack(">" + CODES[kind], value)
            case StringType():
                yield struct.pack(">i", len(value) + 1) + value + b"\0"
            case SequenceType():
                yield struct.pack(">i", len(value))
                for item in value:
                    yield from self._encoded(element(slot), item)
            case ArrayType():
                for item in value:
                    yield from self._encoded(element(slot), item)
            case MapType(key, kind):
                yield struct.pack(">i", len(entries(value)))
                for k, v in entries(value):
                    yield from self._encoded(Slot(key), k)
                    yield from self._encoded(Slot(kind), v)
            case NamedType(name):
                yield self._named(name, value)

    def _named(self, name: str, value: Any) -> bytes:
        declaration = self._model.find(name)
        match declaration:
            case Interface():
                return self.fields(list(REFERENCE), value)
            case EnumDeclaration(bit_bound=bits):
                return struct.pack(">q" if bits > 32 else ">i", value)
            case Bitmask(bit_bound=bits):
                return struct.pack(">Q" if bits > 32 else ">I", value)
            case Bitset(bit_size=bits):
                number = 0
                for f, given in zip(named_fields(self._model, declaration), value, strict=True):
                    number |= (given & ((1 << f.width) - 1)) << f.position
                return struct.pack(">Q" if bits > 32 else ">I", number)
            case Struct() if is_hand_written(declaration):
                assert isinstance(value, bytes)
                return value
            case Struct() | Union():
                inside = self.contents(name, value)
                grows = declaration.extensibility.value == "appendable"
                return struct.pack(">i", len(inside)) + inside if grows else inside
        raise AssertionError(name)

    def _union(self, union: Union, value: Any) -> bytes:
        tag, index, held = value
        wide = False
        match union.discriminator:
            case PrimitiveType(kind):
                wide = kind in (Primitive.UINT32, Primitive.UINT64, Primitive.INT64)
            case NamedType(name):
                declaration = self._model.find(name)
                assert isinstance(declaration, EnumDeclaration | Bitmask)
                wide = declaration.bit_bound > 32
        out: bytes = (tag & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "big")
        out = out if wide else out[4:]
        for at, slot in enumerate(arms(union), start=1):
            out += bytes([at == index])
            if at == index:
                out += self.encoded(slot, held[0])
        return out

    # -- what is wrong -------------------------------------------------------------------------

    def wrong(self, slot: Slot, value: Any) -> str:
        """Why the value must not be sent; empty when it may."""
        return next(self._wrong(slot, value), "")

    def any_wrong(self, slots: list[Slot], values: list[Any]) -> str:
        found = (self.wrong(s, v) for s, v in zip(slots, values, strict=True))
        return next(filter(None, found), "")

    def _wrong(self, slot: Slot, value: Any) -> Iterator[str]:
        slot = settled(self._model, slot)
        if slot.optional:
            for held in value:
                yield from self._wrong(Slot(slot.type, slot.range), held)
            return
        match slot.type:
            case PrimitiveType(kind):
                yield from _out_of_range(slot, kind, value)
            case StringType(bound):
                yield from _wrong_text(value, bound)
            case SequenceType(_, bound):
                if bound is not None and len(value) > bound:
                    yield f"{len(value)} elements of {bound}"
                for item in value:
                    yield from self._wrong(element(slot), item)
            case ArrayType():
                for item in value:
                    yield from self._wrong(element(slot), item)
            case MapType(key, kind, bound):
                if bound is not None and len(value) > bound:
                    yield f"{len(value)} entries of {bound}"
                for k, v in value:
                    yield from self._wrong(Slot(key), k)
                    yield from self._wrong(Slot(kind), v)
            case NamedType(name):
                yield from self._wrong_named(name, value)

    def _wrong_named(self, name: str, value: Any) -> Iterator[str]:
        declaration = self._model.find(name)
        match declaration:
            case Interface():
                for slot, item in zip(REFERENCE, value, strict=True):
                    yield from self._wrong(slot, item)
            case Bitset():
                for f, given in zip(named_fields(self._model, declaration), value, strict=True):
                    low, high = _limits_of(f)
                    if not low <= given <= high:
                        yield f"{WRONG_BITS}: {given} in {f.width}"
            case Struct() if not is_hand_written(declaration):
                for slot, item in zip(members(self._model, declaration), value, strict=True):
                    yield from self._wrong(slot, item)
            case Union():
                tag, index, held = value
                if chosen(self._model, declaration, tag) != index:
                    yield f"{WRONG_ARM}: {index} with tag {tag}"
                for item in held:
                    yield from self._wrong(arms(declaration)[index - 1], item)


def _limits_of(field: Any) -> tuple[int, int]:
    """Smallest and largest number of a bitset's field."""
    kind = field.type.kind
    if kind is not Primitive.BOOLEAN and not kind.is_unsigned:
        return -(1 << (field.width - 1)), (1 << (field.width - 1)) - 1
    return 0, (1 << field.width) - 1


def _out_of_range(slot: Slot, kind: Primitive, value: Any) -> Iterator[str]:
    if slot.range is None or not kind.is_number:
        return
    low, high = slot.range.minimum, slot.range.maximum
    if kind is Primitive.FLOAT:
        value = rounded(value)
        low = None if low is None else rounded(low)
        high = None if high is None else rounded(high)
    fits = (low is None or value >= low) and (high is None or value <= high)
    if not fits or value != value:
        yield f"{value} is not within {low} and {high}"


def _wrong_text(value: bytes, bound: int | None) -> Iterator[str]:
    if bound is not None and len(value) > bound:
        yield f"{len(value)} bytes of {bound}"
    if b"\0" in value:
        yield "NUL in a text"
    try:
        value.decode()
    except UnicodeDecodeError:
        yield "no UTF-8"
