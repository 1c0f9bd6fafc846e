"""The interface description that the session uses. It consists of constant tables that gidl
generates.

Each operation declares its parameters and its result once, as steps of `gecos.wire.layout`. The
codecs of proxies and servants are derived from these steps. `gecos/description.hpp` has the same
tables for C++. `_core` reads the Python tables by the names of their attributes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import IntEnum, IntFlag
from functools import cached_property
from types import MappingProxyType
from typing import Any, Generic, TypeVar

from gecos.errors import DeclaredError
from gecos.record import Record, replace
from gecos.wire import Decoder, Parts
from gecos.wire.in_place import OctetsInPlace
from gecos.wire.kinds import Kind as Carried
from gecos.wire.kinds import Nested, kind_of
from gecos.wire.layout import Step
from gecos.wire.members import Arguments, StructLayout
from gecos.wire.plans import from_start

T = TypeVar("T")
F = TypeVar("F")


class Access(IntEnum):
    """The status that an operation requires of its caller. A status includes all lower ones."""

    SENSOR = 0
    ACTOR = 1
    MASTER = 2


class Kind(IntEnum):
    OPERATION = 0
    GETTER = 1
    SETTER = 2


class OnNew(IntEnum):
    QUEUE = 0
    REJECT = 1
    PREEMPT = 2
    BLEND = 3


class OnLoss(IntEnum):
    STOP = 0
    FINISH = 1


class OnDegraded(IntEnum):
    EVENT = 0
    FAIL = 1
    FAILOVER = 2


class QualityClass(IntEnum):
    TIME_INDEPENDENT = 0
    SOFT_REALTIME = 1
    HARD_REALTIME = 2


class Reliability(IntEnum):
    """RELIABLE demands a medium that loses nothing, BEST_EFFORT demands nothing. DEFAULT is
    RELIABLE for a call, and BEST_EFFORT for the samples of a stream."""

    DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2


class Media(IntFlag):
    """Media that a connection may use. INPROC is allowed wherever SHM is allowed."""

    INPROC = 1
    SHM = 2
    LCM = 4
    TCP = 8
    CAN = 16


ANY_MEDIUM = Media(0)


class Quality(Record, kw_only=True):
    """The quality that an interface, operation or stream demands of a connection. A duration of 0
    means that there is no such demand."""

    line: QualityClass = QualityClass.TIME_INDEPENDENT
    reliability: Reliability = Reliability.DEFAULT
    deadline_ns: int = 0
    start_by_ns: int = 0
    latency_ns: int = 0
    lifespan_ns: int = 0
    # True if only the samples of a stream show that its writer is alive. False if the heartbeats of
    # the writer's process show it.
    manual_liveliness: bool = False
    depth: int = 0
    media: Media = ANY_MEDIUM
    on_degraded: OnDegraded = OnDegraded.EVENT  # only an interface has this term


ASKED_NOTHING = Quality()


def quality_of_calls(of_stream: Quality) -> Quality:
    """Returns the quality that the getter and the setter of a stream demand. Leaves out the
    deadline, which limits the time between two samples, and the reliability, which applies only to
    samples."""
    return replace(of_stream, deadline_ns=0, reliability=Reliability.DEFAULT)


class Operation(Record):
    code: int
    name: str  # for example "move", "tool", or "tool=" for a setter
    access: Access = Access.ACTOR
    kind: Kind = Kind.OPERATION
    safety: bool = False
    presence: bool = True
    idempotent: bool = False
    cancelable: bool = False
    parallel: bool = False
    ordered: bool = False
    on_new: OnNew = OnNew.QUEUE
    on_loss: OnLoss = OnLoss.STOP
    quality: Quality = ASKED_NOTHING
    hash: int = 0


class OutwardStream(Record, kw_only=True):
    """A stream of samples, or an event. The operation with the same function code reads a single
    value; an event has no such operation."""

    code: int
    name: str
    access: Access = Access.SENSOR
    rate_hz: float = 0.0
    largest: int = 0  # bytes of the largest sample; 0 when unbounded
    event: bool = False  # True for an event: a reader gets only samples after its subscription
    hash: int = 0  # hash of an event; 0 for a stream, which has the hash of its getter
    open_fingerprint: int | None = None  # LCM fingerprint of the samples of an @open_stream
    bulk: bool = False  # True if samples have @bulk octets, which can be written in place
    quality: Quality = ASKED_NOTHING


class InwardStream(Record, kw_only=True):
    """A stream of samples that clients send to the servant."""

    code: int
    name: str
    access: Access = Access.ACTOR
    presence: bool = True
    rate_hz: float = 0.0
    watchdog_ns: int = 0  # samples that are older when they are read have no effect; 0: no limit
    largest: int = 0  # bytes of the largest sample; 0 when unbounded
    quality: Quality = ASKED_NOTHING
    hash: int = 0


class Interface(Record, kw_only=True, derived=("models", "handlers")):
    name: str  # "robcl::Rx90"
    version: str = ""
    hash: int = 0
    bases: tuple[str, ...] = ()  # all direct and indirect bases
    operations: tuple[Operation, ...] = ()  # own and all inherited operations
    streams: tuple[OutwardStream, ...] = ()  # own and all inherited streams and events
    inward_streams: tuple[InwardStream, ...] = ()  # own and all inherited inward streams
    quality: Quality = ASKED_NOTHING
    # The object serves these texts: the JSON of the interface and of each of its bases.
    models: tuple[str, ...] = ()
    handlers: Mapping[int, Handler] = MappingProxyType({})

    def __post_init__(self) -> None:
        """Removes duplicates, because several bases may inherit the same operation or stream."""
        for name in ("operations", "streams", "inward_streams", "models"):
            self.__dict__[name] = tuple(dict.fromkeys(getattr(self, name)))


def nothing(source: Decoder) -> None:
    """Decodes the empty reply of an operation without result."""


def no_arguments(source: Decoder) -> tuple[()]:
    """Decodes the empty request of an operation without parameters."""
    return ()


def no_parts() -> Parts:
    """Encodes the empty request of an operation without parameters."""
    return []


def no_result(value: None) -> Parts:
    """Encodes the empty reply of an operation without result."""
    return []


_NO_VALUES = Arguments("", (), (), ())


class Method(Record, Generic[T, F]):
    """How a proxy calls an operation: the decoders of its reply, feedback and exceptions. A
    `Method` that the function `method` builds also has the codec of the arguments and the encoder
    of the reply."""

    operation: Operation
    result: Callable[[Decoder], T]
    feedback: Callable[[Decoder], F] | None = None
    raises: tuple[type[DeclaredError], ...] = ()
    request: Callable[..., Parts] = no_parts  # encodes the arguments
    arguments: Arguments = _NO_VALUES
    body: Callable[[Any], Parts] = no_result  # encodes the value that `result` decodes
    stream: OutwardStream | None = None
    handler: str = ""  # name of the servant's method
    reports: type | None = None  # type of the feedback; None: not known, or no feedback
    gives: Carried | None = None  # layout of the result; None: not known, or no result
    named: str = "result"  # name of the result in JSON
    in_place: OctetsInPlace | None = None  # None: samples are not written in place

    @cached_property
    def decode_reply(self) -> Callable[[bytes], T]:
        """Decodes a result, as `result` does, from the bytes of a reply."""
        return from_start(self.result)

    def plain_result(self, value: T) -> dict[str, Any]:
        """Converts a result to types that the module `json` can dump: {"result": 0.25}, or all
        members if there are several results. C++ writes the same JSON."""
        if self.gives is None:
            return {}
        if _are_several(self.gives):
            members: dict[str, Any] = self.gives.plain(value)
            return members
        return {self.named: self.gives.plain(value)}

    def made_result(self, data: Any) -> T:
        """Converts the output of `plain_result` back to a result. Raises JsonError, which names the
        member. Ranges and bounds are checked when the result is encoded."""
        value: Any
        if self.gives is not None and _are_several(self.gives):
            value = self.gives.made(data, "")
        else:
            single = _NO_VALUES
            if self.gives is not None:
                missing = (None,) if self.gives.may_be_missing else ()
                single = Arguments(self.operation.name, (self.named,), (self.gives,), missing)
            value = next(iter(single.made_values(data)), None)
        return value  # type: ignore[no-any-return]


def _are_several(kind: Carried) -> bool:
    """Returns whether a reply of `kind` consists of several results. The struct of these results is
    encoded without its size."""
    layout = kind.layout if isinstance(kind, Nested) else None
    return isinstance(layout, StructLayout) and layout.open and not layout.in_block


class Handler(Record):
    """How a servant answers a call: its method, the decoder of the arguments, and the encoder of
    the result."""

    operation: Operation
    method: str  # method of the servant; its last parameter is `run` if the operation is cancelable
    arguments: Callable[[Decoder], tuple[Any, ...]]
    result: Callable[[Any], Parts]
    # The exceptions that the handler may send; None stands for every DeclaredError.
    raises: tuple[type[DeclaredError], ...] | None = None
    parameters: Sequence[str] | None = None  # names of the parameters; None: not known
    feedback: type | None = None  # None: not known, or the operation has none


def values(names: str, *steps: Step, defaults: tuple[Any, ...] = ()) -> tuple[Any, ...]:
    """Describes the parameters of an operation: their names, and a layout step for each. `defaults`
    belong to the last parameters, which an older caller may omit."""
    return names.split(), steps, defaults


def method(
    operation: Operation,
    *,
    takes: tuple[Any, ...] | None = None,
    gives: Step | None = None,
    named: str = "result",
    feedback: type | None = None,
    raises: tuple[type[DeclaredError], ...] = (),
    stream: tuple[float, int] | None = None,
    open_fingerprint: int | None = None,
    handler: str = "",
    in_place: str = "",
) -> Method[Any, Any]:
    """Builds the `Method` of an operation. If an `out` parameter is the only result, `named` is its
    name. If the result is also published as a stream, `stream` is the rate of the stream in Hz and
    the size of its largest sample in bytes (0: unbounded). `open_fingerprint` is the LCM
    fingerprint of the samples of an open stream. `handler` is the name of the servant's method, if
    it differs from the name of the operation. `in_place` is the member of which the octets can be
    written and read in place."""
    name, sender = operation.name, operation.name.removesuffix("=")
    result, body = (nothing, no_result) if gives is None else _answer(kind_of(gives), name)
    outward = None
    if stream is not None:
        rate, largest = stream
        asked = operation.quality
        operation = replace(operation, quality=quality_of_calls(asked))
        outward = OutwardStream(
            code=operation.code,
            name=name,
            access=operation.access,
            rate_hz=rate,
            largest=largest,
            open_fingerprint=open_fingerprint,
            bulk=bool(in_place),
            quality=asked,
        )
    given = None if gives is None else kind_of(gives)
    octets = None
    if in_place and isinstance(given, Nested):
        octets = OctetsInPlace(given.layout, in_place, name)
    arguments = _NO_VALUES if takes is None else Arguments(sender, *takes)
    return Method(
        operation,
        result,
        None if feedback is None else feedback.decode,  # type: ignore[attr-defined]
        raises,
        arguments.encode,
        arguments,
        body,
        outward,
        handler or (name if name == sender else f"set_{sender}"),
        feedback,
        given,
        named,
        octets,
    )


class Inward(Record, Generic[T]):
    """An inward stream with the codec of its samples."""

    stream: InwardStream
    result: Callable[[Decoder], T]  # decodes a sample
    body: Callable[[T], Parts]  # encodes a sample


def inward(
    code: int,
    name: str,
    access: Access,
    *,
    gives: Step,
    presence: bool = True,
    rate_hz: float = 0.0,
    watchdog_ns: int = 0,
    largest: int = 0,
    quality: Quality = ASKED_NOTHING,
    hash: int,
) -> Inward[Any]:
    """Describes an inward stream."""
    stream = InwardStream(
        code=code,
        name=name,
        access=access,
        presence=presence,
        rate_hz=rate_hz,
        watchdog_ns=watchdog_ns,
        largest=largest,
        quality=quality,
        hash=hash,
    )
    return Inward(stream, *_answer(kind_of(gives), name))


class Event(Record, Generic[T]):
    """An event with the codec of its parameters."""

    stream: OutwardStream
    result: Callable[[Decoder], T]  # decodes the parameters
    body: Callable[[T], Parts]  # encodes the parameters


def event(
    code: int,
    name: str,
    access: Access,
    *,
    gives: Step,
    largest: int = 0,
    quality: Quality = ASKED_NOTHING,
    hash: int,
) -> Event[Any]:
    """Describes an event."""
    stream = OutwardStream(
        code=code,
        name=name,
        access=access,
        largest=largest,
        event=True,
        hash=hash,
        quality=quality,
    )
    return Event(stream, *_answer(kind_of(gives), name))


def _answer(kind: Carried, label: str) -> tuple[Callable[[Decoder], Any], Callable[[Any], Parts]]:
    """Returns the functions that decode and encode a reply, a sample, or the parameters of an
    event."""

    def read(source: Decoder) -> Any:
        return kind.take(source, label)

    def written(value: Any) -> Parts:
        out: Parts = []
        kind.put(value, out, label)
        return out

    if isinstance(kind, Nested) and not kind.layout.in_block:
        return kind.kind.decode, written
    return read, written


def getter(
    code: int,
    name: str,
    access: Access,
    *,
    parallel: bool = False,
    on_new: OnNew = OnNew.QUEUE,
    on_loss: OnLoss = OnLoss.STOP,
    quality: Quality = ASKED_NOTHING,
    hash: int,
) -> Operation:
    """Describes the operation that reads an attribute."""
    return Operation(
        code,
        name,
        access,
        kind=Kind.GETTER,
        presence=False,
        idempotent=True,
        parallel=parallel,
        on_new=on_new,
        on_loss=on_loss,
        quality=quality,
        hash=hash,
    )


def interface(
    name: str,
    version: str,
    hash: int,
    bases: Iterable[type],
    methods: Iterable[Method[Any, Any]],
    quality: Quality = ASKED_NOTHING,
    model: str = "",
    inward: Iterable[Inward[Any]] = (),
    events: Iterable[Event[Any]] = (),
) -> Interface:
    """Builds an interface with its own and all inherited members. `bases` are proxy classes, and
    `model` is the JSON of the interface itself."""
    inherited: list[Interface] = [base._gecos_interface for base in bases]  # type: ignore[attr-defined]
    own = tuple(methods)
    handlers = {code: each for base in inherited for code, each in base.handlers.items()}
    for each in own:
        handlers[each.operation.code] = Handler(
            each.operation,
            each.handler,
            each.arguments.decode,
            each.body,
            each.raises,
            each.arguments.names,
            each.reports,
        )
    names = dict.fromkeys(n for base in inherited for n in (*base.bases, base.name))
    operations = [o for base in inherited for o in base.operations]
    streams = [s for base in inherited for s in base.streams]
    inward_streams = [s for base in inherited for s in base.inward_streams]
    return Interface(
        name=name,
        version=version,
        hash=hash,
        bases=tuple(names),
        operations=(*operations, *(each.operation for each in own)),
        streams=(
            *streams,
            *(each.stream for each in own if each.stream is not None),
            *(each.stream for each in events),
        ),
        inward_streams=(*inward_streams, *(each.stream for each in inward)),
        quality=quality,
        models=(*(m for base in inherited for m in base.models), *([model] if model else ())),
        handlers=handlers,
    )
