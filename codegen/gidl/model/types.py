"""Locations, values and types, as declarations use them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum


@dataclass(frozen=True, slots=True, order=True)
class Location:
    """A place in a source file: the path as in `#include` ("robcl/frame.gidl"), and the line and
    column, both counted from 1."""

    file: str
    line: int
    column: int


# ---------------------------------------------------------------------------------------------
# Values


@dataclass(frozen=True, slots=True)
class EnumValue:
    """An enumerator (or a flag of a bitmask) used as a value."""

    enum: str  # scoped name of the enum or bitmask
    literal: str
    number: int


Value = bool | int | float | str | EnumValue
"""A constant. A `char` is a `str` of one character. Expressions are already computed."""


@dataclass(frozen=True, slots=True)
class Annotation:
    """An annotation that gidl does not interpret. It belongs to another IDL vocabulary, or the
    author of the file declared it."""

    name: str
    arguments: tuple[tuple[str, Value], ...] = ()  # names and values; @a(v) gives ("value", v)
    location: Location | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Range:
    """The inclusive bounds of a number; None means that the number has no bound on that side."""

    minimum: int | float | None = None
    maximum: int | float | None = None


def within(inner: Range | None, outer: Range | None) -> Range | None:
    """Returns the intersection of two ranges; None stands for a range without bounds."""
    if inner is None or outer is None:
        return inner or outer
    lower = [m for m in (inner.minimum, outer.minimum) if m is not None]
    upper = [m for m in (inner.maximum, outer.maximum) if m is not None]
    return Range(max(lower, default=None), min(upper, default=None))


# ---------------------------------------------------------------------------------------------
# Types as they are used


class Primitive(Enum):
    BOOLEAN = "boolean"
    OCTET = "octet"
    CHAR = "char"
    INT8 = "int8"
    UINT8 = "uint8"
    INT16 = "int16"
    UINT16 = "uint16"
    INT32 = "int32"
    UINT32 = "uint32"
    INT64 = "int64"
    UINT64 = "uint64"
    FLOAT = "float"
    DOUBLE = "double"

    @property
    def size(self) -> int:
        """Size on the wire, in bytes."""
        return _PRIMITIVE_SIZE[self.value]

    @property
    def is_integer(self) -> bool:
        """True if the type is an integer type. Octets count as integers; characters and booleans do
        not."""
        return self.value.startswith(("int", "uint")) or self is Primitive.OCTET

    @property
    def is_floating(self) -> bool:
        return self in (Primitive.FLOAT, Primitive.DOUBLE)

    @property
    def is_number(self) -> bool:
        return self.is_integer or self.is_floating

    @property
    def is_unsigned(self) -> bool:
        return self.value.startswith("uint") or self is Primitive.OCTET

    @property
    def integer_limits(self) -> tuple[int, int]:
        """Returns the smallest and the largest value of an integer type. @pre `is_integer`."""
        bits = 8 * self.size
        if self.is_unsigned:
            return 0, (1 << bits) - 1
        return -(1 << (bits - 1)), (1 << (bits - 1)) - 1


BUILT_IN = "gecos::GecosObject"
"""The interface of the built-in operations, which every object has besides its own interface."""

_PRIMITIVE_SIZE = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2,
    "int32": 4, "uint32": 4, "int64": 8, "uint64": 8, "float": 4, "double": 8,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class PrimitiveType:
    kind: Primitive


@dataclass(frozen=True, slots=True)
class StringType:
    bound: int | None = None  # largest size in bytes of UTF-8, without the NUL


@dataclass(frozen=True, slots=True)
class SequenceType:
    element: Type
    bound: int | None = None
    unit: str | None = None  # unit of the elements, from an annotation inside `sequence<>`


@dataclass(frozen=True, slots=True)
class MapType:
    key: Type
    value: Type
    bound: int | None = None


@dataclass(frozen=True, slots=True)
class ArrayType:
    element: Type  # no ArrayType, but perhaps a typedef of an array
    dimensions: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class NamedType:
    """A type that is used by its name: a struct, exception, enum, union, typedef, bitmask, bitset
    or interface."""

    name: str


Type = PrimitiveType | StringType | SequenceType | MapType | ArrayType | NamedType


def named_in(used: Type) -> Iterator[str]:
    """Yields the names of the declarations that a type mentions, for example "lab::Pose" for
    `sequence<lab::Pose>`. Typedefs are not resolved."""
    match used:
        case NamedType(name):
            yield name
        case SequenceType(element=element) | ArrayType(element=element):
            yield from named_in(element)
        case MapType(key, value):
            yield from named_in(key)
            yield from named_in(value)
