"""What the session needs to know of an interface: constant tables that gidl generates.

The twin of `gecos/description.hpp`; `_core` reads these objects by their attributes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum, IntFlag
from typing import Any, Generic, TypeVar

from gecos.errors import DeclaredError
from gecos.wire import Decoder, Parts

T = TypeVar("T")
F = TypeVar("F")


class Access(IntEnum):
    """Status that a caller needs; each includes the ones before it."""

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


class QualityClass(IntEnum):
    TIME_INDEPENDENT = 0
    SOFT_REALTIME = 1
    HARD_REALTIME = 2


class Media(IntFlag):
    """Media that a line may take. One process is as good as its shared memory: INPROC is allowed
    where SHM is."""

    INPROC = 1
    SHM = 2
    LCM = 4
    TCP = 8
    CAN = 16


ANY_MEDIUM = Media(0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """What a line is asked to be. A duration of zero means: not asked."""

    line: QualityClass = QualityClass.TIME_INDEPENDENT
    best_effort: bool = False
    deadline_ns: int = 0
    start_by_ns: int = 0
    latency_ns: int = 0
    lifespan_ns: int = 0
    depth: int = 0
    media: Media = ANY_MEDIUM


@dataclass(frozen=True, slots=True, kw_only=True)
class Operation:
    code: int
    name: str  # "move", "tool", "tool=" for a setter
    kind: Kind = Kind.OPERATION
    access: Access = Access.ACTOR
    safety: bool = False
    presence: bool = True
    idempotent: bool = False
    cancelable: bool = False
    parallel: bool = False
    ordered: bool = False
    on_new: OnNew = OnNew.QUEUE
    on_loss: OnLoss = OnLoss.STOP
    quality: Quality = field(default_factory=Quality)
    hash: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class OutwardStream:
    """Its one-shot getter is the operation with the same code."""

    code: int
    name: str
    access: Access = Access.SENSOR
    rate_hz: float = 0.0
    largest: int = 0  # bytes of the largest sample; 0 when unbounded
    quality: Quality = field(default_factory=Quality)


@dataclass(frozen=True, slots=True, kw_only=True)
class Interface:
    name: str  # "robcl::Rx90"
    version: str = ""
    hash: int = 0
    bases: tuple[str, ...] = ()  # every interface it also is
    operations: tuple[Operation, ...] = ()  # own and all inherited
    streams: tuple[OutwardStream, ...] = ()  # likewise
    quality: Quality = field(default_factory=Quality)

    def __post_init__(self) -> None:
        """Several bases may bring the same ones, which it has once."""
        object.__setattr__(self, "operations", tuple(dict.fromkeys(self.operations)))
        object.__setattr__(self, "streams", tuple(dict.fromkeys(self.streams)))


@dataclass(frozen=True)  # no slots: Method[T, F](…) writes an attribute of its own
class Method(Generic[T, F]):
    """How a proxy calls an operation: reads its reply body, its feedback, its exceptions."""

    operation: Operation
    result: Callable[[Decoder], T]
    feedback: Callable[[Decoder], F] | None = None
    raises: tuple[type[DeclaredError], ...] = ()


@dataclass(frozen=True, slots=True)
class Handler:
    """How a servant answers an operation: which of its methods, with which bytes in and out."""

    operation: Operation
    method: str  # of the servant; it takes `run` last when the operation is cancelable
    arguments: Callable[[Decoder], tuple[Any, ...]]
    result: Callable[[Any], Parts]
    raises: tuple[type[DeclaredError], ...] | None = None  # None: whatever the servant raises


def nothing(source: Decoder) -> None:
    """Reads the reply of an operation without result."""


def no_arguments(source: Decoder) -> tuple[()]:
    """Reads the request of an operation without parameters."""
    return ()


def no_result(value: None) -> Parts:
    """Writes the reply of an operation without result."""
    return []
