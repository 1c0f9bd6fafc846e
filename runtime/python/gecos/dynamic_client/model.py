"""The model that an object serves: its interfaces, and the types that they use.

`gecos.dynamic_client.read` makes a model from the served texts. The members of its interfaces also
describe the object for people: `description_of(proxy).members`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from gecos.dynamic_client.names import simple
from gecos.dynamic_client.type_text import Type
from gecos.interface import ASKED_NOTHING, Access, OnLoss, OnNew, Quality
from gecos.record import Record

OBJECT_REFERENCE = "gecos::ObjectRef"
"""The type of references to objects. A value has this type if its declared type is an interface."""


class ModelError(ValueError):
    """A served model is not valid. `interface` is the object's interface; `why` has the place in
    the model and the reason."""

    def __init__(self, interface: str, why: str) -> None:
        super().__init__(f"the model of {interface} is not valid: {why}")
        self.interface = interface
        self.why = why

    def __reduce__(self) -> tuple[type[ModelError], tuple[str, str]]:
        return ModelError, (self.interface, self.why)


class Limits(Record):
    """An inclusive range. If `low` or `high` is None, the range has no limit on that side."""

    low: int | float | None
    high: int | float | None

    def __str__(self) -> str:
        if self.low is None:
            return f"at most {self.high}"
        return f"at least {self.low}" if self.high is None else f"{self.low} to {self.high}"


def within(inner: Limits | None, outer: Limits | None) -> Limits | None:
    """Returns the intersection of two ranges; None stands for a range without limits."""
    if inner is None or outer is None:
        return inner or outer
    lows = [each.low for each in (inner, outer) if each.low is not None]
    highs = [each.high for each in (inner, outer) if each.high is not None]
    return Limits(max(lows, default=None), min(highs, default=None))


class Value(Record, kw_only=True, derived=("use",)):
    """A member of a type, a parameter, a result, or the value of an attribute."""

    name: str
    type: str  # as in .gidl, for example "sequence<double, 6>"
    use: Type  # `type`, parsed
    direction: str = "in"  # "in", "out" or "inout"
    unit: str = ""
    limits: Limits | None = None
    # None: no default. Enumerators are scoped names, for example "robcl::Blend::BREAK".
    default: Any = None
    optional: bool = False
    secret: bool = False
    doc: str = ""

    @property
    def range(self) -> str:
        """The declared range as a text for people, for example "0.01 to 1.0"; "" if no range is
        declared."""
        return "" if self.limits is None else str(self.limits)

    @property
    def may_be_missing(self) -> bool:
        return self.optional or self.default is not None


# -- types -----------------------------------------------------------------------------------------


class Struct(Record):
    """A struct or an exception."""

    name: str  # scoped name, for example "robcl::Frame"
    members: tuple[Value, ...]  # without inherited members
    base: str = ""
    appendable: bool = False
    fingerprint: int = 0
    is_exception: bool = False
    doc: str = ""


class Enumeration(Record):
    name: str
    enumerators: tuple[tuple[str, int], ...]
    otherwise: str | None = None  # enumerator that readers use for unknown numbers
    bits: int = 32
    doc: str = ""

    @property
    def initial(self) -> str:
        """The name of the enumerator that a member has before it is set."""
        return self.otherwise or self.enumerators[0][0]


class Bitmask(Record):
    name: str
    flags: tuple[tuple[str, int], ...]  # names and positions
    bits: int
    doc: str = ""


class Bitset(Record):
    name: str
    fields: tuple[tuple[str, int, int, str], ...]  # name, position, width, name of the type
    base: str
    bits: int
    doc: str = ""


class Case(Record):
    """An arm of a union. If `labels` is empty, the arm is selected by all tags that select no other
    arm."""

    labels: tuple[Any, ...]
    member: Value


class Union(Record):
    name: str
    discriminator: Type
    cases: tuple[Case, ...]
    appendable: bool = False
    fingerprint: int = 0
    doc: str = ""


class Typedef(Record):
    name: str
    use: Type
    limits: Limits | None = None
    doc: str = ""


Declaration = Struct | Enumeration | Bitmask | Bitset | Union | Typedef


# -- interfaces ------------------------------------------------------------------------------------


class Operation(Record, kw_only=True):
    name: str
    interface: str  # scoped name of the interface that declares the member
    doc: str = ""
    parameters: tuple[Value, ...] = ()
    result: Value | None = None
    feedback: str = ""  # name of the feedback's type
    raises: tuple[str, ...] = ()
    access: Access = Access.ACTOR
    safety: bool = False
    presence: bool = True
    idempotent: bool = False
    cancelable: bool = False
    parallel: bool = False
    ordered: bool = False
    on_new: OnNew = OnNew.QUEUE
    on_loss: OnLoss = OnLoss.STOP
    quality: Quality = ASKED_NOTHING
    code: int = 0
    hash: int = 0

    kind = "operation"

    @property
    def inputs(self) -> tuple[Value, ...]:
        return tuple(each for each in self.parameters if each.direction != "out")

    @property
    def outputs(self) -> tuple[Value, ...]:
        """The result, then the `out` and `inout` parameters."""
        result = () if self.result is None else (self.result,)
        return result + tuple(each for each in self.parameters if each.direction != "in")


class AttributeStream(Record):
    direction: str  # "out": the server publishes; "in": the server receives
    rate_hz: float = 0.0  # 0: not declared
    largest: int = 0  # bytes of the largest sample; 0 when unbounded
    watchdog_ns: int = 0  # watchdog time of an inward stream; 0: no watchdog
    open: bool = False  # True for an open stream, which is also sent in clear over lcm


class Attribute(Record, kw_only=True):
    """An attribute or an event. The value of an attribute can be read unless clients send its
    samples (`inward`). An event is a stream of structs, whose members are the parameters."""

    name: str
    interface: str
    result: Value  # the value
    doc: str = ""
    readonly: bool = False
    stream: AttributeStream | None = None
    event: bool = False
    access: Access = Access.SENSOR  # status needed to read the value and its stream
    write_access: Access = Access.ACTOR
    write_presence: bool = True
    idempotent: bool = False
    parallel: bool = False
    on_new: OnNew = OnNew.QUEUE
    on_loss: OnLoss = OnLoss.STOP
    raises: tuple[str, ...] = ()  # exceptions that reading may raise
    set_raises: tuple[str, ...] = ()
    quality: Quality = ASKED_NOTHING
    code: int = 0
    set_code: int = 0
    hash: int = 0

    parameters = ()
    feedback = ""

    @property
    def kind(self) -> str:
        return "event" if self.event else "attribute"

    @property
    def inward(self) -> bool:
        return self.stream is not None and self.stream.direction == "in"

    @property
    def can_be_read(self) -> bool:
        return not self.inward and not self.event

    @property
    def can_be_set(self) -> bool:
        return self.can_be_read and not self.readonly

    @property
    def can_be_watched(self) -> bool:
        return not self.inward and self.stream is not None


Member = Operation | Attribute


class Interface(Record, kw_only=True):
    name: str
    version: str = ""
    doc: str = ""
    bases: tuple[str, ...] = ()  # direct bases
    members: tuple[Member, ...] = ()  # without inherited members
    quality: Quality = ASKED_NOTHING
    hash: int = 0


class Model(Record):
    """An interface, its bases, and all types that they use."""

    interface: str
    interfaces: Mapping[str, Interface]  # each interface comes after its bases
    types: Mapping[str, Declaration]
    references: frozenset[str]  # interfaces that are used as types

    @property
    def own(self) -> Interface:
        return self.interfaces[self.interface]

    @property
    def members(self) -> tuple[Member, ...]:
        """All inherited and own members."""
        return tuple(m for each in self.interfaces.values() for m in each.members)

    def resolved(self, use: Type, limits: Limits | None = None) -> tuple[Type, Limits | None]:
        """Returns the type and the limits of a value, with typedefs resolved. Typedefs of its
        elements are not resolved."""
        while use.kind == "named" and isinstance(alias := self.types.get(use.name), Typedef):
            use, limits = alias.use, within(limits, alias.limits)
        return use, limits

    def all_members(self, struct: Struct) -> tuple[Value, ...]:
        """Returns the members of a struct; those of its bases come first."""
        base = self.types.get(struct.base)
        return (*(self.all_members(base) if isinstance(base, Struct) else ()), *struct.members)

    def all_fields(self, bitset: Bitset) -> tuple[tuple[str, int, int, str], ...]:
        base = self.types.get(bitset.base)
        return (*(self.all_fields(base) if isinstance(base, Bitset) else ()), *bitset.fields)

    def default_of(self, value: Value) -> Any:
        """Returns the declared default as plain data, with the simple names of enumerators; None if
        there is no default."""
        use, _ = self.resolved(value.use)
        return self.plain_literal(value.default, use)

    def plain_literal(self, literal: Any, use: Type) -> Any:
        declared = self.types.get(use.name) if use.kind == "named" else None
        if isinstance(literal, str) and isinstance(declared, Enumeration):
            return literal.removeprefix(f"{declared.name}::")
        if isinstance(literal, str) and isinstance(declared, Bitmask):
            return literal.removeprefix(f"{declared.name}::").split("|")
        return literal

    def direct_uses(self, declaration: Declaration) -> Iterator[Type]:
        """Yields the type of each value that a value of the declared type directly contains."""
        if isinstance(declaration, Struct):
            yield from (each.use for each in self.all_members(declaration))
        elif isinstance(declaration, Union):
            yield declaration.discriminator
            yield from (case.member.use for case in declaration.cases)
        elif isinstance(declaration, Typedef):
            yield declaration.use

    def class_name(self, scoped: str) -> str:
        """Returns the name of the class of a type. A type inside another type has both names, for
        example `Manipulator_Mode`."""
        scope, _, name = scoped.rpartition("::")
        while scope in self.types or scope in self.interfaces or scope in self.references:
            name = f"{simple(scope)}_{name}"
            scope = scope.rpartition("::")[0]
        return name
