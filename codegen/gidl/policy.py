"""Access, quality and streams: the needs of a caller and the promises of a connection.

Durations are whole nanoseconds, rates are hertz. `None` means "not set".
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum, IntEnum


class Access(IntEnum):
    """Status that a caller needs. The values are ordered: master includes actor, actor includes
    sensor."""

    SENSOR = 0
    ACTOR = 1
    MASTER = 2


class OnNew(Enum):
    """What a new actor command does while another actor command of the object is running."""

    QUEUE = "queue"
    REJECT = "reject"
    PREEMPT = "preempt"
    BLEND = "blend"


class OnLoss(Enum):
    """What happens to a running actor operation when its holder is lost."""

    STOP = "stop"
    FINISH = "finish"


class QualityClass(IntEnum):
    """How strict the timing promises of a connection are; the values are in rising strictness."""

    TIME_INDEPENDENT = 0
    SOFT_REALTIME = 1
    HARD_REALTIME = 2


class Reliability(IntEnum):
    BEST_EFFORT = 0
    RELIABLE = 1


class Liveliness(IntEnum):
    AUTOMATIC = 0
    MANUAL = 1


class StreamDirection(Enum):
    """Direction as seen by the server: it publishes OUT and accepts IN."""

    OUT = "out"
    IN = "in"


@dataclass(frozen=True, slots=True)
class Qos:
    """Quality terms (QoS) of a connection. A term that is None is not set."""

    quality_class: QualityClass | None = None
    reliability: Reliability | None = None
    deadline_ns: int | None = None
    start_by_ns: int | None = None
    latency_ns: int | None = None
    lifespan_ns: int | None = None
    liveliness: Liveliness | None = None
    depth: int | None = None
    media: tuple[str, ...] | None = None

    def over(self, outer: Qos) -> Qos:
        """This quality; each term that it does not set is taken from `outer`."""
        merged = {}
        for field in fields(self):
            own = getattr(self, field.name)
            merged[field.name] = getattr(outer, field.name) if own is None else own
        return Qos(**merged)

    @property
    def is_empty(self) -> bool:
        return self == UNSAID


UNSAID = Qos()


@dataclass(frozen=True, slots=True)
class Stream:
    """The stream of an attribute: the server or a client publishes samples continuously."""

    direction: StreamDirection
    rate_hz: float | None = None
    watchdog_ns: int | None = None  # longest silence of the sender of an inward stream
    is_open: bool = False  # @open_stream, outward streams: samples are bare LCM messages over lcm
