"""Random neutral values: mostly fine ones, often at the ends of their ranges; and such that have
one thing wrong with them. Secrets have a token in them that must never be seen again."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from random import Random
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
    Union,
)
from neutral import (
    REFERENCE,
    Slot,
    arms,
    chosen,
    element,
    is_hand_written,
    members,
    named_fields,
    number_of,
    settled,
)
from opinion import rounded

TOKEN = b"q7Z"  # in every secret that has room for it
DEEPEST = 3
TEXTS = (b"", b"a", b"plain text", "Grüße, 速度".encode(), b'"\\\n\t\x7f', "\U0001f916".encode())
Spoil = Callable[[], None]


class Making:
    def __init__(self, model: Model, dice: Random) -> None:
        self._model = model
        self._dice = dice
        self._spoils: list[Spoil] = []
        self._open: list[str] = []  # named types around, so that recursion ends

    def values(self, slots: list[Slot], spoiled: bool) -> list[Any]:
        """One value for each; where `spoiled`, with one thing wrong if there is any that can be."""
        self._spoils = []
        made: list[Any] = [None] * len(slots)
        for index, slot in enumerate(slots):
            self._into(made, index, slot)
        if spoiled and self._spoils:
            self._dice.choice(self._spoils)()
        return made

    def _into(self, holder: list[Any], index: int, slot: Slot) -> None:
        """Puts a value there, and remembers how it can be spoiled."""
        slot = settled(self._model, slot)
        if slot.optional:
            holder[index] = []
            if self._dice.random() < 0.7:
                holder[index].append(None)
                self._into(holder[index], 0, Slot(slot.type, slot.range, secret=slot.secret))
            return
        match slot.type:
            case PrimitiveType(kind):
                self._number(holder, index, kind, slot.range)
            case StringType(bound):
                self._text(holder, index, bound, slot.secret)
            case SequenceType(_, bound):
                most = 3 if bound is None else min(3, bound)
                holder[index] = self._list(element(slot), self._count(most))
                if bound is not None and bound < 40:
                    self._spoils.append(lambda: self._grow(holder[index], element(slot), bound))
            case ArrayType(_, dimensions):
                holder[index] = self._list(element(slot), dimensions[0])
            case MapType():
                self._map(holder, index, slot.type)
            case NamedType(name):
                self._named(holder, index, name)

    def _count(self, most: int) -> int:
        if len(self._open) > DEEPEST:
            return 0
        return self._dice.randint(0, most)

    def _list(self, slot: Slot, size: int) -> list[Any]:
        made: list[Any] = [None] * size
        for index in range(size):
            self._into(made, index, slot)
        return made

    def _grow(self, items: list[Any], slot: Slot, bound: int) -> None:
        kept = self._spoils
        while len(items) <= bound:
            items.append(None)
            self._into(items, len(items) - 1, slot)
        self._spoils = kept

    # -- numbers and texts ---------------------------------------------------------------------

    def _number(self, holder: list[Any], index: int, kind: Primitive, limits: Range | None) -> None:
        if kind is Primitive.BOOLEAN:
            holder[index] = self._dice.randint(0, 1)
        elif kind is Primitive.CHAR:
            holder[index] = self._dice.choice((0, 1, 39, 65, 97, 127, 128, 255))
        elif kind.is_floating:
            self._floating(holder, index, kind, limits)
        else:
            least, most = kind.integer_limits
            low = least if limits is None or limits.minimum is None else int(limits.minimum)
            high = most if limits is None or limits.maximum is None else int(limits.maximum)
            ends = (low, high, min(low + 1, high), max(high - 1, low), min(max(0, low), high))
            holder[index] = self._dice.choice((*ends, self._dice.randint(low, high)))
            outside = [n for n in (low - 1, high + 1, least, most) if least <= n <= most]
            self._offer(holder, index, [n for n in outside if not low <= n <= high])

    def _floating(
        self, holder: list[Any], index: int, kind: Primitive, limits: Range | None
    ) -> None:
        step = math.nextafter if kind is Primitive.DOUBLE else _next_single
        low = None if limits is None else limits.minimum
        high = None if limits is None else limits.maximum
        if kind is Primitive.FLOAT:
            low = None if low is None else rounded(low)
            high = None if high is None else rounded(high)
        usual = (0.0, 1.0, -1.0, self._dice.uniform(-10, 10), -0.0, math.inf, -math.inf, 1e30)
        ends = [float(end) for end in (low, high) if end is not None]
        ends += (
            [float(end) for end in (limits.minimum, limits.maximum) if end is not None]
            if limits
            else []
        )
        ends += [step(end, to) for end in ends for to in (math.inf, -math.inf)]
        fits = [
            n
            for n in (*usual, *ends, *ends)
            if (low is None or _as(kind, n) >= low) and (high is None or _as(kind, n) <= high)
        ]
        holder[index] = self._dice.choice(fits)
        if limits is not None:
            outside = [n for n in (*usual, *ends) if n not in fits]
            self._offer(holder, index, [*outside, math.nan])

    def _text(self, holder: list[Any], index: int, bound: int | None, secret: bool) -> None:
        text = self._dice.choice(TEXTS)
        if secret:
            text = TOKEN + text
        if bound is not None:
            text = text[:bound]
            while not _is_text(text):
                text = text[:-1]
        holder[index] = text
        shown = TOKEN if secret else b"x"
        wrong = [shown + b"\xff", b"\xc3" + shown, shown + b"\0", b"\xed\xa0\x80" + shown]
        if bound is not None and bound < 1000:
            wrong += [shown + b"y" * bound] * 2
        self._offer(holder, index, wrong)

    def _offer(self, holder: list[Any], index: int, wrong: list[Any]) -> None:
        for number in wrong:
            self._spoils.append(lambda number=number: holder.__setitem__(index, number))  # type: ignore[misc]

    # -- what is made of others ----------------------------------------------------------------

    def _map(self, holder: list[Any], index: int, used: MapType) -> None:
        most = 3 if used.bound is None else min(3, used.bound)
        entries: list[list[Any]] = []
        for _ in range(self._count(most)):
            entry = [None, None]
            before = len(self._spoils)
            self._into(entry, 0, Slot(used.key))
            if any(entry[0] == key for key, _ in entries):
                del self._spoils[before:]
                continue
            self._into(entry, 1, Slot(used.value))
            entries.append(entry)
        holder[index] = entries

    def _named(self, holder: list[Any], index: int, name: str) -> None:
        declaration = self._model.find(name)
        self._open.append(name)
        match declaration:
            case Interface():
                holder[index] = self._list_of(list(REFERENCE))
            case EnumDeclaration():
                holder[index] = self._dice.choice(declaration.enumerators).number
            case Bitmask():
                flags = [1 << f.position for f in declaration.flags]
                holder[index] = sum(flag for flag in flags if self._dice.random() < 0.5)
            case Bitset():
                self._bits(holder, index, declaration)
            case Struct() if is_hand_written(declaration):
                holder[index] = hand_written(name)
            case Struct():
                holder[index] = self._list_of(members(self._model, declaration))
            case Union():
                self._union(holder, index, declaration)
        self._open.pop()

    def _list_of(self, slots: list[Slot]) -> list[Any]:
        made: list[Any] = [None] * len(slots)
        for at, slot in enumerate(slots):
            self._into(made, at, slot)
        return made

    def _bits(self, holder: list[Any], index: int, bitset: Bitset) -> None:
        made: list[int] = []
        holder[index] = made
        for at, field in enumerate(named_fields(self._model, bitset)):
            kind = field.type.kind
            least, most = (0, 1) if kind is Primitive.BOOLEAN else kind.integer_limits
            signed = least < 0
            low = -(1 << (field.width - 1)) if signed else 0
            high = (1 << (field.width - signed)) - 1
            made.append(self._dice.choice((low, high, self._dice.randint(low, high))))
            outside = [n for n in (low - 1, high + 1, least, most) if least <= n <= most]
            self._offer(made, at, [n for n in outside if not low <= n <= high])

    def _union(self, holder: list[Any], index: int, union: Union) -> None:
        tag = self._dice.choice(self._tags(union))
        at = chosen(self._model, union, tag)
        made: list[Any] = [tag, at, []]
        holder[index] = made
        if at:
            made[2].append(None)
            self._into(made[2], 0, arms(union)[at - 1])
        others = [t for t in self._tags(union) if chosen(self._model, union, t) != at]
        self._offer(made, 0, others)

    def _tags(self, union: Union) -> list[int]:
        labels = [number_of(self._model, union, n) for case in union.cases for n in case.labels]
        match union.discriminator:
            case PrimitiveType(Primitive.BOOLEAN):
                return [0, 1]
            case PrimitiveType(Primitive.CHAR):
                return [*labels, 0, 127, 128, 255]
            case PrimitiveType(kind):
                least, most = kind.integer_limits
                return [*labels, *labels, least, most, min(7, most)]
            case NamedType(name):
                declaration = self._model.find(name)
                if isinstance(declaration, EnumDeclaration):
                    return [e.number for e in declaration.enumerators]
                return [*labels, 0]


def hand_written(name: str) -> bytes:
    """A value of a class that is written by hand, as it is on the wire."""
    assert name == "robcl::Frame", name
    return struct.pack(">7d", 1, 2, 3, 1, 0, 0, 0)


def _as(kind: Primitive, number: float) -> float:
    return rounded(number) if kind is Primitive.FLOAT else number


def _next_single(number: float, towards: float) -> float:
    """The float of 32 bits beside `number`, or a number in between that is rounded."""
    if math.isinf(number) or number == 0:
        return number
    return number * (1 + 1.2e-7 * math.copysign(1, towards) * math.copysign(1, number))


def _is_text(text: bytes) -> bool:
    try:
        text.decode()
    except UnicodeDecodeError:
        return False
    return True
