"""The declarations of a file, except interfaces: structs, unions, enums, typedefs and constants."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from gidl.model.types import Annotation, Location, NamedType, PrimitiveType, Range, Type, Value


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts that every declaration has: documentation, annotations and locations."""

    location: Location = field(compare=False)
    doc: str = ""  # the author's comment without comment marks; its lines are joined by "\n"
    version: str | None = None  # text of @version, such as "1.2"
    since: str | None = None
    deprecated: str | None = None  # the reason, or "" without a reason; None: not deprecated
    hash_as: str | None = None  # name from which codes and hashes are computed
    annotations: tuple[Annotation, ...] = ()  # annotations that gidl does not interpret
    written: tuple[tuple[str, Location], ...] = field(default=(), compare=False)
    """The locations of the annotations that gidl interprets, and of their arguments. The names are
    for example "qos" and "qos.depth"."""

    def place_of(self, *annotations: str) -> Location:
        """Returns the location of the first of `annotations` that the declaration has. If it has
        none of them, returns the location of its name."""
        return next((at for name, at in self.written if name in annotations), self.location)

    def has(self, annotation: str) -> bool:
        """Returns whether the declaration has this annotation, which must be one that gidl
        interprets."""
        return any(name == annotation for name, _ in self.written)


@dataclass(frozen=True, slots=True)
class Member:
    """A member of a struct or exception, or the value of a union case."""

    name: str
    type: Type
    facts: Facts
    unit: str | None = None
    range: Range | None = None
    default: Value | None = None
    optional: bool = False
    id: int | None = None
    bulk: bool = False
    secret: bool = False


class Extensibility(Enum):
    FINAL = "final"
    APPENDABLE = "appendable"


@dataclass(frozen=True, slots=True)
class MapsTo:
    """The hand-written value types that replace a struct. `cpp` has the type and its header, for
    example "robcl::Frame" and "robcl/frames/frame.hpp". `python` has the module and the class, for
    example "robcl.frames" and "Frame"."""

    cpp: tuple[str, str] | None = None
    python: tuple[str, str] | None = None


@dataclass(frozen=True, slots=True)
class Declaration:
    name: str  # scoped name, such as "robcl::Frame"
    facts: Facts

    @property
    def simple_name(self) -> str:
        return self.name.rpartition("::")[2]

    @property
    def scope(self) -> str:
        """The scoped name of the enclosing module, interface, struct or union; "" at the top
        level."""
        return self.name.rpartition("::")[0]


@dataclass(frozen=True, slots=True)
class Struct(Declaration):
    members: tuple[Member, ...]  # without inherited members: see `Model.all_members`
    base: str | None = None
    extensibility: Extensibility = Extensibility.FINAL
    maps_to: MapsTo | None = None

    @property
    def is_appendable(self) -> bool:
        return self.extensibility is Extensibility.APPENDABLE


@dataclass(frozen=True, slots=True)
class ExceptionStruct(Struct):
    """An exception that an operation may raise. An exception has members like a struct, but is
    never used as a value."""


@dataclass(frozen=True, slots=True)
class Enumerator:
    name: str  # unscoped name; an enumerator is declared in the scope around its enum
    number: int
    facts: Facts


@dataclass(frozen=True, slots=True)
class EnumDeclaration(Declaration):
    enumerators: tuple[Enumerator, ...]
    default_literal: str | None = None  # the enumerator that readers use for unknown numbers
    bit_bound: int = 32

    @property
    def initial(self) -> Enumerator:
        """The value of a member that is not set: the default literal, or else the first
        enumerator."""
        for enumerator in self.enumerators:
            if enumerator.name == self.default_literal:
                return enumerator
        return self.enumerators[0]


@dataclass(frozen=True, slots=True)
class Flag:
    name: str
    position: int
    facts: Facts


@dataclass(frozen=True, slots=True)
class Bitmask(Declaration):
    flags: tuple[Flag, ...]
    bit_bound: int = 32


@dataclass(frozen=True, slots=True)
class Bitfield:
    name: str | None  # None: the bits are padding
    position: int  # index of the lowest bit, counted over the bits of the bases too
    width: int
    # The declared type. A field without a declared type is boolean if it has one bit, else the
    # smallest unsigned integer that is wide enough.
    type: PrimitiveType
    facts: Facts

    @property
    def is_signed(self) -> bool:
        """True if the highest bit is a sign."""
        return self.type.kind.is_integer and not self.type.kind.is_unsigned


@dataclass(frozen=True, slots=True)
class Bitset(Declaration):
    fields: tuple[Bitfield, ...]  # without inherited fields: see `Model.all_fields`
    base: str | None
    bit_size: int  # number of bits, those of the bases included


@dataclass(frozen=True, slots=True)
class UnionCase:
    labels: tuple[Value, ...]  # values of the `case` labels; empty if there is only `default:`
    is_default: bool
    member: Member


@dataclass(frozen=True, slots=True)
class Union(Declaration):
    discriminator: PrimitiveType | NamedType  # without typedefs; a NamedType is an enum or bitmask
    cases: tuple[UnionCase, ...]
    extensibility: Extensibility = Extensibility.FINAL


@dataclass(frozen=True, slots=True)
class Typedef(Declaration):
    type: Type
    unit: str | None = None
    range: Range | None = None


@dataclass(frozen=True, slots=True)
class Constant(Declaration):
    type: Type
    value: Value
    unit: str | None = None


@dataclass(frozen=True, slots=True)
class AnnotationParameter:
    name: str
    type: Type | None  # None: the type `any`
    default: Value | None


@dataclass(frozen=True, slots=True)
class AnnotationDeclaration(Declaration):
    parameters: tuple[AnnotationParameter, ...]
