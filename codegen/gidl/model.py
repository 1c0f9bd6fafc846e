"""The meaning of a set of .gidl files: immutable and free of any target language.

A declaration is known by its scoped name ("robcl::Frame", no leading "::"). Types refer to
declarations by that name, so recursive types need no cycles; `Model.find` follows a name.
Everything a rule, the wire layout or a target may ask is here, resolved: no annotation needs to be
read again, constants are values, quality and access are what applies after inheritance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

from gidl.policy import UNSAID, Access, OnLoss, OnNew, Qos, Stream, StreamDirection


@dataclass(frozen=True, slots=True, order=True)
class Location:
    """Place in a source file: path as included ("robcl/frame.gidl"), line and column from 1."""

    file: str
    line: int
    column: int


# ---------------------------------------------------------------------------------------------
# Values


@dataclass(frozen=True, slots=True)
class EnumValue:
    """An enumerator (or a flag of a bitmask) used as a value."""

    enum: str  # scoped name of the enum
    literal: str
    number: int


Value = bool | int | float | str | EnumValue
"""A constant. A `char` is a `str` of one character. Expressions are already computed."""


@dataclass(frozen=True, slots=True)
class Annotation:
    """An annotation that gidl does not interpret: of another vocabulary, or user-defined."""

    name: str
    arguments: tuple[tuple[str, Value], ...] = ()  # in the order written; ("value", v) for @a(v)
    location: Location | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Range:
    """Inclusive bounds of a number; either side may be open."""

    minimum: int | float | None = None
    maximum: int | float | None = None


def within(inner: Range | None, outer: Range | None) -> Range | None:
    """Both ranges at once: the narrower bound of each side."""
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
        """Bytes on the wire."""
        return _PRIMITIVE_SIZE[self.value]

    @property
    def is_integer(self) -> bool:
        """Octets count as integers; characters and booleans do not."""
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
        """Smallest and largest value. Only for integers."""
        bits = 8 * self.size
        if self.is_unsigned:
            return 0, (1 << bits) - 1
        return -(1 << (bits - 1)), (1 << (bits - 1)) - 1


BUILT_IN = "gecos::GecosObject"
"""The interface that every object has besides its own."""

_PRIMITIVE_SIZE = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2,
    "int32": 4, "uint32": 4, "int64": 8, "uint64": 8, "float": 4, "double": 8,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class PrimitiveType:
    kind: Primitive


@dataclass(frozen=True, slots=True)
class StringType:
    bound: int | None = None  # bytes of UTF-8, without the NUL


@dataclass(frozen=True, slots=True)
class SequenceType:
    element: Type
    bound: int | None = None
    unit: str | None = None  # unit of the elements, when the sequence is annotated


@dataclass(frozen=True, slots=True)
class MapType:
    key: Type
    value: Type
    bound: int | None = None


@dataclass(frozen=True, slots=True)
class ArrayType:
    element: Type  # never itself an ArrayType, except through a typedef
    dimensions: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class NamedType:
    """A declared type: struct, exception, enum, union, typedef, bitmask, bitset or interface."""

    name: str


Type = PrimitiveType | StringType | SequenceType | MapType | ArrayType | NamedType


# ---------------------------------------------------------------------------------------------
# Declarations


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts of every declaration: documentation, annotations, locations."""

    location: Location = field(compare=False)
    doc: str = ""  # text of the author's comment without comment marks; lines joined by "\n"
    version: str | None = None  # "1.2"
    since: str | None = None
    deprecated: str | None = None  # the reason; "" when none is given
    hash_as: str | None = None  # name used for codes and hashes instead of the present one
    annotations: tuple[Annotation, ...] = ()  # unknown annotations, kept
    written: tuple[tuple[str, Location], ...] = field(default=(), compare=False)
    """Locations of annotations with a meaning and of their arguments: "qos", "qos.depth"."""

    def place_of(self, *annotations: str) -> Location:
        """Where one of these annotations stands, else where the name is declared."""
        return next((at for name, at in self.written if name in annotations), self.location)

    def has(self, annotation: str) -> bool:
        """Whether this annotation of ours was written."""
        return any(name == annotation for name, _ in self.written)


@dataclass(frozen=True, slots=True)
class Member:
    """A member of a struct, exception or union arm."""

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
    """Hand-written value types: `cpp` is ("robcl::Frame", "robcl/frames/frame.hpp"),
    `python` is ("robcl.frames", "Frame")."""

    cpp: tuple[str, str] | None = None
    python: tuple[str, str] | None = None


@dataclass(frozen=True, slots=True)
class Declaration:
    name: str  # scoped
    facts: Facts

    @property
    def simple_name(self) -> str:
        return self.name.rpartition("::")[2]

    @property
    def scope(self) -> str:
        """Scoped name of the module, interface, struct or union around it, "" at the top."""
        return self.name.rpartition("::")[0]


@dataclass(frozen=True, slots=True)
class Struct(Declaration):
    members: tuple[Member, ...]  # own ones; `Model.all_members` has those of the bases first
    base: str | None = None
    extensibility: Extensibility = Extensibility.FINAL
    maps_to: MapsTo | None = None

    @property
    def is_appendable(self) -> bool:
        return self.extensibility is Extensibility.APPENDABLE


@dataclass(frozen=True, slots=True)
class ExceptionStruct(Struct):
    """An exception that an operation may raise: a struct that is never used as a value."""


@dataclass(frozen=True, slots=True)
class Enumerator:
    name: str  # simple; it lives in the scope around its enum
    number: int
    facts: Facts


@dataclass(frozen=True, slots=True)
class EnumDeclaration(Declaration):
    enumerators: tuple[Enumerator, ...]
    default_literal: str | None = None  # what an unknown number becomes; None: it is an error
    bit_bound: int = 32

    @property
    def initial(self) -> Enumerator:
        """Value of an unset member: the default literal, else the first."""
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
    name: str | None  # None is padding
    position: int  # lowest bit, those of the bases counted
    width: int
    type: (
        PrimitiveType  # as written, else the smallest unsigned (boolean for one bit) that holds it
    )
    facts: Facts


@dataclass(frozen=True, slots=True)
class Bitset(Declaration):
    fields: tuple[Bitfield, ...]  # own ones
    base: str | None
    bit_size: int  # with those of the bases


@dataclass(frozen=True, slots=True)
class UnionCase:
    labels: tuple[Value, ...]  # empty for a pure `default:`
    is_default: bool
    member: Member


@dataclass(frozen=True, slots=True)
class Union(Declaration):
    discriminator: PrimitiveType | NamedType  # typedefs followed; NamedType is an enum or bitmask
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
    type: Type | None  # None is `any`
    default: Value | None


@dataclass(frozen=True, slots=True)
class AnnotationDeclaration(Declaration):
    parameters: tuple[AnnotationParameter, ...]


class Direction(Enum):
    IN = "in"
    OUT = "out"
    INOUT = "inout"


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    type: Type
    direction: Direction
    facts: Facts
    unit: str | None = None
    range: Range | None = None
    default: Value | None = None
    optional: bool = False
    secret: bool = False
    bulk: bool = False


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation, or an event (then the server is the caller and clients have subscribed)."""

    name: str
    interface: str  # scoped name of the declaring interface
    parameters: tuple[Parameter, ...]
    result: Type | None  # None is void
    facts: Facts
    raises: tuple[str, ...] = ()  # scoped names of exceptions, in the order written
    oneway: bool = False
    is_event: bool = False
    access: Access = Access.ACTOR
    access_written: bool = False
    safety: bool = False
    needs_presence: bool = True  # False for sensor operations and @presence(FALSE)
    idempotent: bool = False
    cancelable: bool = False
    feedback: NamedType | None = None  # for a cancelable operation; None when untyped
    on_new: OnNew = OnNew.QUEUE
    parallel: bool = False
    ordered: bool = False
    on_loss: OnLoss = OnLoss.STOP
    qos: Qos = UNSAID  # what applies: own terms over the interface's over its bases'
    result_unit: str | None = None
    result_range: Range | None = None
    result_optional: bool = False
    result_bulk: bool = False
    result_secret: bool = False
    id: int | None = None  # @id

    @property
    def scoped_name(self) -> str:
        return f"{self.interface}::{self.name}"

    @property
    def inputs(self) -> tuple[Parameter, ...]:
        return tuple(p for p in self.parameters if p.direction is not Direction.OUT)

    @property
    def outputs(self) -> tuple[Parameter, ...]:
        """`out` and `inout` parameters, without the result."""
        return tuple(p for p in self.parameters if p.direction is not Direction.IN)


@dataclass(frozen=True, slots=True)
class Attribute:
    """A value of an object: got, set, streamed. Which of these exists is said by the properties."""

    name: str
    interface: str
    type: Type
    readonly: bool
    facts: Facts
    stream: Stream | None = None
    read_access: Access = Access.SENSOR  # getter and outward stream
    write_access: Access = Access.ACTOR  # setter or inward stream
    access_written: bool = False
    write_needs_presence: bool = True
    get_raises: tuple[str, ...] = ()
    set_raises: tuple[str, ...] = ()
    qos: Qos = UNSAID
    unit: str | None = None
    range: Range | None = None
    optional: bool = False
    secret: bool = False
    bulk: bool = False
    id: int | None = None

    @property
    def scoped_name(self) -> str:
        return f"{self.interface}::{self.name}"

    @property
    def streams_in(self) -> bool:
        return self.stream is not None and self.stream.direction is StreamDirection.IN

    @property
    def streams_out(self) -> bool:
        return self.stream is not None and self.stream.direction is StreamDirection.OUT

    @property
    def idempotent(self) -> bool:
        """False: a getter or setter is sent at most once, like any call not declared idempotent."""
        return False

    @property
    def on_new(self) -> OnNew:
        """A setter queues like any actor command, ..."""
        return OnNew.QUEUE

    @property
    def on_loss(self) -> OnLoss:
        """... ends with the status of its caller, ..."""
        return OnLoss.STOP

    @property
    def parallel(self) -> bool:
        """... and runs alone."""
        return False

    @property
    def has_getter(self) -> bool:
        """An inward stream cannot be got by a call."""
        return not self.streams_in

    @property
    def has_setter(self) -> bool:
        return not self.readonly and not self.streams_in


@dataclass(frozen=True, slots=True)
class Interface(Declaration):
    bases: tuple[str, ...]  # direct ones, as written
    all_bases: tuple[str, ...]  # each once, a base before what derives from it
    members: tuple[Operation | Attribute, ...]  # own ones, in the order written
    nested: tuple[str, ...] = ()  # scoped names of what is declared inside, in order
    qos: Qos = UNSAID  # what decides `create`, inherited terms included

    @property
    def operations(self) -> tuple[Operation, ...]:
        """Own operations without events."""
        return tuple(m for m in self.members if isinstance(m, Operation) and not m.is_event)

    @property
    def events(self) -> tuple[Operation, ...]:
        return tuple(m for m in self.members if isinstance(m, Operation) and m.is_event)

    @property
    def attributes(self) -> tuple[Attribute, ...]:
        return tuple(m for m in self.members if isinstance(m, Attribute))


AnyDeclaration = (
    Struct | EnumDeclaration | Bitmask | Bitset | Union | Typedef | Constant | Interface
    | AnnotationDeclaration
)  # fmt: skip


# ---------------------------------------------------------------------------------------------
# Files and the whole


@dataclass(frozen=True, slots=True)
class File:
    path: str  # as others include it, "robcl/geometry.gidl"
    includes: tuple[str, ...]  # paths of the files it includes directly, in order
    declarations: tuple[AnyDeclaration, ...]  # in order, flat; nested ones before what is around
    asked_for: bool = True  # named on the command line; False: only included
    doc: str = ""
    modules: tuple[Declaration, ...] = ()  # its openings of modules, in order

    @property
    def has_interface(self) -> bool:
        return any(isinstance(d, Interface) for d in self.declarations)


@dataclass(frozen=True, slots=True)
class Model:
    files: tuple[File, ...]  # a file after those it includes
    _index: dict[str, AnyDeclaration] = field(init=False, repr=False, compare=False)
    _homes: dict[str, str] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index = {d.name: d for f in self.files for d in f.declarations}
        homes = {d.name: f.path for f in self.files for d in f.declarations}
        object.__setattr__(self, "_index", index)
        object.__setattr__(self, "_homes", homes)

    def find(self, name: str) -> AnyDeclaration:
        """The declaration called `name`. @pre it exists; resolve has seen to that."""
        return self._index[name]

    def has(self, name: str) -> bool:
        return name in self._index

    def file_of(self, name: str) -> str:
        """Path of the file that declares `name`."""
        return self._homes[name]

    def declarations(self) -> Iterator[AnyDeclaration]:
        for file in self.files:
            yield from file.declarations

    def interfaces(self) -> Iterator[Interface]:
        for declaration in self.declarations():
            if isinstance(declaration, Interface):
                yield declaration

    def interface(self, name: str) -> Interface:
        found = self.find(name)
        assert isinstance(found, Interface), name
        return found

    def struct(self, name: str) -> Struct:
        found = self.find(name)
        assert isinstance(found, Struct), name
        return found

    def target(self, used: Type) -> Type:
        """`used` with typedefs at its top followed."""
        while isinstance(used, NamedType):
            declaration = self.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            used = declaration.type
        return used

    def all_members(self, struct: Struct) -> tuple[Member, ...]:
        """Members of the bases first, then its own."""
        inherited = self.all_members(self.struct(struct.base)) if struct.base else ()
        return inherited + struct.members

    def all_fields(self, bitset: Bitset) -> tuple[Bitfield, ...]:
        """Fields of the bases first, then its own."""
        if bitset.base is None:
            return bitset.fields
        base = self.find(bitset.base)
        assert isinstance(base, Bitset)
        return self.all_fields(base) + bitset.fields

    def with_bases(self, interface: Interface) -> tuple[Interface, ...]:
        """All bases, most general first, then the interface itself."""
        return (*(self.interface(name) for name in interface.all_bases), interface)

    def all_interface_members(self, interface: Interface) -> tuple[Operation | Attribute, ...]:
        """All members of an object of this interface, inherited ones first."""
        return tuple(m for i in self.with_bases(interface) for m in i.members)
