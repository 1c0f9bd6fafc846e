"""An interface by hand, in the form that gidl gives generated Python:

exception Burnt { long hours; };
@sensor @stream readonly attribute double level;
@actor @cancelable(feedback="double") void shine(in double goal) raises (Burnt);
@actor double dim(in double by);
@actor @cancelable void burn_in();
@sensor @idempotent string label();
@sensor @cancelable void watch();
"""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import gecos
from gecos.interface import (
    Access,
    Handler,
    Interface,
    Kind,
    Method,
    Operation,
    OutwardStream,
    no_arguments,
    no_result,
    nothing,
)
from gecos.wire import Decoder, Fields, Parts, string

_DOUBLE = Fields("d", ["value"])
_HOURS = Fields("i", ["hours"])


@dataclass(eq=False)
class Burnt(gecos.DeclaredError):
    """The lamp is at its end."""

    _gecos_name: ClassVar[str] = "test::Burnt"
    hours: int = 0

    def encode(self, out: Parts, /) -> None:
        out.append(_HOURS.pack(self.hours))

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        return cls(*_HOURS.unpack(source))


@dataclass(slots=True)
class Glow:
    value: float = 0.0

    def encode(self, out: Parts, /) -> None:
        out.append(_DOUBLE.pack(self.value))

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        return cls(*_DOUBLE.unpack(source))

    @staticmethod
    def fingerprint() -> int:
        return 0


def _double(source: Decoder) -> float:
    value: float = _DOUBLE.unpack(source)[0]
    return value


def _double_argument(source: Decoder) -> tuple[float]:
    return (_double(source),)


def _double_result(value: float) -> Parts:
    return [_DOUBLE.pack(value)]


def _string(source: Decoder) -> str:
    return source.string(field="label")


def _string_result(value: str) -> Parts:
    return [string(value)]


SHINE = Method(
    Operation(code=0x1001, name="shine", cancelable=True), nothing, Glow.decode, (Burnt,)
)
LEVEL_STREAM = OutwardStream(code=0x1002, name="level", rate_hz=100.0, largest=8)
LEVEL = Method[float, None](
    Operation(code=0x1002, name="level", kind=Kind.GETTER, access=Access.SENSOR), _double
)
DIM = Method[float, None](Operation(code=0x1003, name="dim"), _double)
BURN_IN = Method[None, None](Operation(code=0x1004, name="burn_in", cancelable=True), nothing)
LABEL = Method[str, None](
    Operation(code=0x1005, name="label", access=Access.SENSOR, idempotent=True), _string
)
WATCH = Method[None, None](
    Operation(code=0x1006, name="watch", access=Access.SENSOR, cancelable=True), nothing
)
LAMP = Interface(
    name="test::Lamp",
    version="1.0",
    operations=tuple(m.operation for m in (SHINE, LEVEL, DIM, BURN_IN, LABEL, WATCH)),
    streams=(LEVEL_STREAM,),
)


class Lamp(gecos.Object):
    _gecos_interface = LAMP

    @property
    def level(self) -> gecos.StreamAttribute[float]:
        return gecos.StreamAttribute(self, LEVEL)

    def shine(self, goal: float) -> gecos.Command[None, Glow]:
        return self._gecos_call(SHINE, [_DOUBLE.pack(goal)])

    def dim(self, by: float) -> gecos.Command[float]:
        return self._gecos_call(DIM, [_DOUBLE.pack(by)])

    def burn_in(self) -> gecos.Command[None]:
        return self._gecos_call(BURN_IN, [])

    def label(self) -> gecos.Command[str]:
        return self._gecos_call(LABEL, [])

    def watch(self) -> gecos.Command[None]:
        return self._gecos_call(WATCH, [])


class Heater(gecos.Object):
    """Another type."""

    _gecos_interface = Interface(name="test::Heater")


class LampServant(gecos.Servant):
    _gecos_interface = LAMP
    _gecos_handlers: ClassVar[dict[int, Handler]] = {
        0x1001: Handler(SHINE.operation, "shine", _double_argument, no_result, SHINE.raises),
        0x1002: Handler(LEVEL.operation, "level", no_arguments, _double_result),
        0x1003: Handler(DIM.operation, "dim", _double_argument, _double_result),
        0x1004: Handler(BURN_IN.operation, "burn_in", no_arguments, no_result),
        0x1005: Handler(LABEL.operation, "label", no_arguments, _string_result, LABEL.raises),
        0x1006: Handler(WATCH.operation, "watch", no_arguments, no_result),
    }

    @abstractmethod
    def shine(self, goal: float, run: gecos.Execution[Glow]) -> None: ...

    @abstractmethod
    def level(self) -> float: ...

    @abstractmethod
    def dim(self, by: float) -> float: ...

    @abstractmethod
    def burn_in(self, run: gecos.Execution[None]) -> None: ...

    @abstractmethod
    def label(self) -> str: ...

    @abstractmethod
    def watch(self, run: gecos.Execution[None]) -> None: ...

    def publish_level(self, value: float, stamp: float | None = None) -> None:
        self._gecos_publish(0x1002, [_DOUBLE.pack(value)], stamp)

    def publish_damaged_level(self) -> None:
        self._gecos_publish(0x1002, [_DOUBLE.pack(0.0)[:-1]], None)


class PlainLamp(LampServant):
    """Does at once what it is asked; `burn_in` lasts until it is interrupted or `finish` is set."""

    def __init__(self) -> None:
        self.value = 0.0
        self.starts: list[str] = []
        self.burning = threading.Event()  # burn_in has begun
        self.finish = threading.Event()
        self.interrupted = threading.Event()
        self.stopped = threading.Event()
        self.before_label: Callable[[], Any] = lambda: None

    def shine(self, goal: float, run: gecos.Execution[Glow]) -> None:
        self.starts.append("shine")
        if goal > 100:
            raise Burnt(hours=int(goal))
        if goal < 0:
            raise gecos.Rejected("a lamp does not shine darkness; ask for 0 or more")
        self.value = goal
        run.progress(1.0, Glow(goal))

    def level(self) -> float:
        return self.value

    def dim(self, by: float) -> float:
        self.starts.append("dim")
        if by == 0:
            raise ZeroDivisionError("dimmed by nothing")
        self.value /= by
        return self.value

    def burn_in(self, run: gecos.Execution[None]) -> None:
        self.starts.append("burn_in")
        run.progress(0.25)
        self.burning.set()
        while not self.finish.is_set():
            if run.wait_interrupted(0.005):
                self.interrupted.set()
                raise gecos.Interrupted
        run.progress(1.0)

    def label(self) -> str:
        self.before_label()
        return "a lamp"

    def watch(self, run: gecos.Execution[None]) -> None:
        self.starts.append("watch")

    def gecos_on_stop(self) -> None:
        self.stopped.set()
