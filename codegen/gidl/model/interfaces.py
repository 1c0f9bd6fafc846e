"""Interfaces, with their operations and attributes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from gidl.model.declarations import Declaration, Facts
from gidl.model.policy import UNSAID, Access, OnLoss, OnNew, Qos, Stream, StreamDirection
from gidl.model.types import NamedType, Range, Type, Value


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
    feedback: NamedType | None = None  # type of the feedback; None: no typed feedback
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
    def sends_samples(self) -> bool:
        """True for an event: its quality (`qos`) then applies to samples, not to calls."""
        return self.is_event

    @property
    def qos_of_calls(self) -> Qos:
        return self.qos

    @property
    def inputs(self) -> tuple[Parameter, ...]:
        return tuple(p for p in self.parameters if p.direction is not Direction.OUT)

    @property
    def outputs(self) -> tuple[Parameter, ...]:
        """The `out` and `inout` parameters. The result of the operation is not one of them."""
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
    # The event that this attribute stands for; None for other attributes. The samples of the stream
    # are the parameters of the event: see gidl.wire.events.
    event: Operation | None = None

    @property
    def scoped_name(self) -> str:
        return f"{self.interface}::{self.name}"

    @property
    def sends_samples(self) -> bool:
        """True if the attribute has a stream: its quality (`qos`) then applies to the samples."""
        return self.stream is not None

    @property
    def qos_of_calls(self) -> Qos:
        """The quality of the getter and the setter."""
        return self.qos.of_calls_of_stream if self.sends_samples else self.qos

    @property
    def streams_in(self) -> bool:
        return self.stream is not None and self.stream.direction is StreamDirection.IN

    @property
    def streams_out(self) -> bool:
        return self.stream is not None and self.stream.direction is StreamDirection.OUT

    @property
    def idempotent(self) -> bool:
        """Always False, because a setter is never sent a second time. A getter is idempotent in the
        generated tables, whatever this property returns."""
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
        """False for an attribute with an inward stream, and for the attribute that stands for an
        event: clients cannot read their values by a call."""
        return not self.streams_in and self.event is None

    @property
    def has_setter(self) -> bool:
        return not self.readonly and not self.streams_in


@dataclass(frozen=True, slots=True)
class Interface(Declaration):
    bases: tuple[str, ...]  # direct bases, in the order written
    all_bases: tuple[str, ...]  # direct and indirect; a base comes before what derives from it
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
