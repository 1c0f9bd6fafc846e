"""The meaning of a set of .gidl files: immutable and independent of target languages.

A declaration is known by its scoped name ("robcl::Frame", no leading "::"). Types refer to
declarations by that name, so the model needs no cyclic references; `Model.find` returns the
declaration of a name. The model holds all that rules, the wire layout and targets need, in resolved
form: annotations are interpreted, constants are values, and quality and access include inherited
terms.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

from gidl.policy import UNSAID, Access, OnLoss, OnNew, Qos, Stream, StreamDirection


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
    """An annotation that gidl does not interpret: it belongs to another IDL vocabulary, or the user
    declared it."""

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
        """Whether the type is an integer type. Octets count as integers; characters and booleans do
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
    bound: int | None = None  # most bytes of UTF-8, without the NUL


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


# ---------------------------------------------------------------------------------------------
# Declarations


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
    """An exception that an operation may raise. It has members like a struct, but is never used as
    a value."""


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
        """Whether the highest bit is a sign."""
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
    """An operation or an event. The server sends an event to the clients that subscribed to it."""

    name: str
    interface: str  # scoped name of the declaring interface
    parameters: tuple[Parameter, ...]
    result: Type | None  # None: void
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
    feedback: NamedType | None = None  # of a cancelable operation; None: untyped
    on_new: OnNew = OnNew.QUEUE
    parallel: bool = False
    ordered: bool = False
    on_loss: OnLoss = OnLoss.STOP
    qos: Qos = UNSAID  # terms that are not set are taken from the interface and its bases
    result_unit: str | None = None
    result_range: Range | None = None
    result_optional: bool = False
    result_bulk: bool = False
    result_secret: bool = False
    id: int | None = None  # argument of @id

    @property
    def scoped_name(self) -> str:
        return f"{self.interface}::{self.name}"

    @property
    def inputs(self) -> tuple[Parameter, ...]:
        return tuple(p for p in self.parameters if p.direction is not Direction.OUT)

    @property
    def outputs(self) -> tuple[Parameter, ...]:
        """The `out` and `inout` parameters, without the result."""
        return tuple(p for p in self.parameters if p.direction is not Direction.IN)


@dataclass(frozen=True, slots=True)
class Attribute:
    """A value of an object. The properties tell whether the attribute has a getter, a setter and a
    stream."""

    name: str
    interface: str
    type: Type
    readonly: bool
    facts: Facts
    stream: Stream | None = None
    read_access: Access = Access.SENSOR  # status needed for the getter and the outward stream
    write_access: Access = Access.ACTOR  # status needed for the setter or the inward stream
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
    # The event whose parameters are the samples of this stream; see gidl.layout.events.
    event: Operation | None = None

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
        """Always False. Getters and setters are sent at most once, as all calls without @idempotent
        are."""
        return False

    @property
    def on_new(self) -> OnNew:
        """Always QUEUE: a setter is queued like any other actor command."""
        return OnNew.QUEUE

    @property
    def on_loss(self) -> OnLoss:
        """Always STOP: a running setter is stopped when its caller loses the needed status."""
        return OnLoss.STOP

    @property
    def parallel(self) -> bool:
        """Always False: a setter never runs in parallel with other actor commands."""
        return False

    @property
    def has_getter(self) -> bool:
        """False for an attribute with an inward stream and for an event, because clients cannot
        read them by a call."""
        return not self.streams_in and self.event is None

    @property
    def has_setter(self) -> bool:
        return not self.readonly and not self.streams_in


@dataclass(frozen=True, slots=True)
class Interface(Declaration):
    bases: tuple[str, ...]  # direct bases, in the order written
    all_bases: tuple[str, ...]  # direct and indirect bases; each before those derived from it
    members: tuple[Operation | Attribute, ...]  # without inherited members, in the order written
    nested: tuple[str, ...] = ()  # scoped names of the declarations inside, in order
    qos: Qos = UNSAID  # quality demanded of a medium, inherited terms included

    @property
    def operations(self) -> tuple[Operation, ...]:
        """The operations that the interface itself declares, without events."""
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
# Files and the model


@dataclass(frozen=True, slots=True)
class File:
    path: str  # path as in `#include`, such as "robcl/geometry.gidl"
    includes: tuple[str, ...]  # paths of the directly included files, in order
    # All declarations, in order. A nested declaration comes before the enclosing one.
    declarations: tuple[AnyDeclaration, ...]
    asked_for: bool = True  # True: named on the command line; False: only included
    doc: str = ""
    modules: tuple[Declaration, ...] = ()  # one for each `module X {` of the file, in order

    @property
    def has_interface(self) -> bool:
        return any(isinstance(d, Interface) for d in self.declarations)


@dataclass(frozen=True, slots=True)
class Model:
    files: tuple[File, ...]  # each file after those it includes
    _index: dict[str, AnyDeclaration] = field(init=False, repr=False, compare=False)
    _homes: dict[str, str] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index = {d.name: d for f in self.files for d in f.declarations}
        homes = {d.name: f.path for f in self.files for d in f.declarations}
        object.__setattr__(self, "_index", index)
        object.__setattr__(self, "_homes", homes)

    def find(self, name: str) -> AnyDeclaration:
        """Returns the declaration with the scoped name `name`. @pre `name` is declared: see
        `has`."""
        return self._index[name]

    def has(self, name: str) -> bool:
        return name in self._index

    def file_of(self, name: str) -> str:
        """Returns the path of the file that declares `name`."""
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
        """Returns the type that `used` stands for, with typedefs resolved. The typedefs of its
        elements stay."""
        while isinstance(used, NamedType):
            declaration = self.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            used = declaration.type
        return used

    def all_members(self, struct: Struct) -> tuple[Member, ...]:
        """Returns all members of a struct; those of its bases come first."""
        inherited = self.all_members(self.struct(struct.base)) if struct.base else ()
        return inherited + struct.members

    def all_fields(self, bitset: Bitset) -> tuple[Bitfield, ...]:
        """Returns all fields of a bitset; those of its bases come first."""
        if bitset.base is None:
            return bitset.fields
        base = self.find(bitset.base)
        assert isinstance(base, Bitset)
        return self.all_fields(base) + bitset.fields

    def with_bases(self, interface: Interface) -> tuple[Interface, ...]:
        """Returns all bases of an interface, the most general first, and then the interface
        itself."""
        return (*(self.interface(name) for name in interface.all_bases), interface)

    def all_interface_members(self, interface: Interface) -> tuple[Operation | Attribute, ...]:
        """Returns all members of an object of this interface; inherited members come first."""
        return tuple(m for i in self.with_bases(interface) for m in i.members)
