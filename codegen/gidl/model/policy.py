"""Access, quality and streams: the status that a caller needs, and the promises of a connection.

Durations are whole nanoseconds, rates are hertz. `None` means "not set".
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import Enum, IntEnum


class Access(IntEnum):
    """The status that a caller needs. The values are ordered: master includes actor, and actor
    includes sensor."""

    SENSOR = 0
    ACTOR = 1
    MASTER = 2


class OnNew(Enum):
    """The reaction of the server to a new actor command while another actor command of the object
    is running."""

    QUEUE = "queue"
    REJECT = "reject"
    PREEMPT = "preempt"
    BLEND = "blend"


class OnLoss(Enum):
    """What the server does with a running actor operation when the holder of the lease is lost."""

    STOP = "stop"
    FINISH = "finish"


class QualityClass(IntEnum):
    """How strictly a connection keeps its promises about time. The values are ordered from the
    least to the most strict."""

    TIME_INDEPENDENT = 0
    SOFT_REALTIME = 1
    HARD_REALTIME = 2


class Reliability(IntEnum):
    BEST_EFFORT = 0
    RELIABLE = 1


class Liveliness(IntEnum):
    AUTOMATIC = 0
    MANUAL = 1


class OnDegraded(Enum):
    """What happens to a session when the connection of the session exceeds the latency that the
    interface of the object demands."""

    EVENT = "event"
    FAIL = "fail"
    FAILOVER = "failover"


class StreamDirection(Enum):
    """The direction of a stream, as the server sees it: the server publishes an OUT stream, and
    receives an IN stream."""

    OUT = "out"
    IN = "in"


@dataclass(frozen=True, slots=True)
class Qos:
    """The quality terms (QoS) of a connection. A term that is None is not set."""

    quality_class: QualityClass | None = None
    reliability: Reliability | None = None
    deadline_ns: int | None = None
    start_by_ns: int | None = None
    latency_ns: int | None = None
    lifespan_ns: int | None = None
    liveliness: Liveliness | None = None
    depth: int | None = None
    media: tuple[str, ...] | None = None
    on_degraded: OnDegraded | None = None  # only an interface has this term

    def over(self, outer: Qos) -> Qos:
        """Returns the terms of this quality. A term that is not set has the value from `outer`."""
        merged = {}
        for field in fields(self):
            own = getattr(self, field.name)
            merged[field.name] = getattr(outer, field.name) if own is None else own
        return Qos(**merged)

    @property
    def inherited_by_samples(self) -> Qos:
        """Returns the terms of an interface that its streams and events inherit. Leaves out the
        reliability, because the reliability of an interface applies only to calls."""
        return replace(self, reliability=None)

    @property
    def of_calls_of_stream(self) -> Qos:
        """Returns the terms of a stream that also apply to calls of its getter and setter. Leaves
        out the deadline, which is the longest time between two samples, and the reliability, which
        applies only to samples."""
        return replace(self, deadline_ns=None, reliability=None)

    @property
    def of_member(self) -> Qos:
        """Returns this quality without the terms that only an interface can have."""
        return replace(self, on_degraded=None)

    @property
    def is_empty(self) -> bool:
        return self == UNSAID


UNSAID = Qos()


@dataclass(frozen=True, slots=True)
class Stream:
    """The stream of an attribute, on which the server or a client publishes samples
    continuously."""

    direction: StreamDirection
    rate_hz: float | None = None
    # The longest time that the sender of an inward stream may be silent.
    watchdog_ns: int | None = None
    is_open: bool = False  # outward streams: over lcm, samples are plain LCM messages
