"""The base of every generated proxy: a handle to a session with an object.

A generated proxy has exactly the members of its interface; the built-in operations of every object
are functions (`gecos.stop(robot)`). Names added by this module begin with `_gecos`. gidl generates:

    _MOVE = method(
        Operation(0x…, "move", Access.ACTOR, cancelable=True),
        takes=values("goal how", Frame, optional(Trajectory), defaults=(None,)),
        feedback=MotionProgress,
        raises=(OutOfReach, JointLimit),
    )
    _TOOL = method(getter(0x…, "tool", Access.SENSOR), gives=Frame, stream=(250.0, 56))
    _MANIPULATOR = interface("robcl::Manipulator", "1.0", 0x…, (Device,), (_MOVE, _TOOL))

    class Manipulator(Device):
        _gecos_interface = _MANIPULATOR

        def move(self, goal: Frame, how: Trajectory | None = None) -> Command[None, MotionProgress]:
            return self._gecos_call(_MOVE, _MOVE.request(goal, how))

        @property
        def tool(self) -> StreamAttribute[Frame]:
            return StreamAttribute(self, _TOOL)
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from functools import partial
from types import FunctionType
from typing import TYPE_CHECKING, ClassVar, Generic, NoReturn, TypeVar

from gecos import interface
from gecos.command import Command
from gecos.errors import CommandFailed, ConnectionFailed, Detail, State
from gecos.interface import Interface, Kind, Method
from gecos.stream import Stream
from gecos.unopened import Unopened
from gecos.wire import Decoder, Parts

if TYPE_CHECKING:
    from gecos_idl.object_ref_types import ObjectRef

    from gecos import _core
    from gecos.wire.in_place import OctetsInPlace

T = TypeVar("T")
F = TypeVar("F")
P = TypeVar("P", bound="Object")


class Object:
    """The base class of proxies. `lab.create` makes a proxy; its copies share one session."""

    _gecos_interface: ClassVar[Interface] = Interface(name="gecos::Object")

    _gecos_session: _core.Session
    _gecos_deadline: float | None

    def __init_subclass__(cls) -> None:
        for name, member in vars(cls).items():
            if isinstance(member, FunctionType) and not name.startswith("_"):
                member.stream = partial(_no_stream, cls, name)  # type: ignore[attr-defined]

    if TYPE_CHECKING:

        def __init__(self, gecos_session: _core.Session) -> None: ...

    else:

        def __init__(self, *given):
            if len(given) != 1 or isinstance(given[0], str):
                name = given[0] if given and isinstance(given[0], str) else "NAME"
                kind = type(self).__name__
                raise TypeError(
                    f"{kind} is a proxy class, and a Lab makes its objects: write "
                    f"`gecos.Lab().create({kind}, {name!r})`"
                )
            self._gecos_session = given[0]
            self._gecos_deadline = None

        # A type checker that saw __setattr__ would allow every assignment.

        def __setattr__(self, name: str, value: object) -> None:
            if not name.startswith("_gecos"):
                setter = "call the method set_…(…) of an attribute that can be set"
                if hasattr(self, f"set_{name}"):
                    setter = f"call set_{name}(…) instead"
                raise AttributeError(f"{self!r}: {name} cannot be assigned; {setter}")
            super().__setattr__(name, value)

    def _gecos_call(self, method: Method[T, F], arguments: Parts) -> Command[T, F]:
        core = self._gecos_session.call(
            method.operation.code, b"".join(arguments), self._gecos_deadline
        )
        return Command(core, method)

    def __repr__(self) -> str:
        session = self._gecos_session
        return f"<{session.interface_name} {session.object_name!r} over {session.medium}>"


def _no_stream(kind: type[Object], name: str) -> NoReturn:
    """Raises TypeError for `.stream()` on a member of a proxy that has no stream."""
    about = kind._gecos_interface
    streams = ", ".join(each.name for each in about.streams) or "none"
    getters = [each.name for each in about.operations if each.kind is Kind.GETTER]
    if name in getters:
        why = "is not published as a stream"
        advice = f"get the value with `.{name}().result()`, or add @stream to the attribute"
    else:
        why = "is an operation and has no stream"
        advice = f"call it with `.{name}(…).result()`"
    raise TypeError(
        f"{kind.__name__}.{name} {why}; {advice}. Streams of {kind.__name__}: {streams}"
    )


class StreamAttribute(Unopened, Generic[T]):
    """An attribute that the server publishes continuously. Call it to get one value, or open its
    stream."""

    __slots__ = ("_method", "_object")

    def __init__(self, owner: Object, method: Method[T, None]) -> None:
        self._object = owner
        self._method = method

    def _to_open(self) -> str:
        return _open_first(self._object, self._method.operation.name, "a stream")

    def __call__(self) -> Command[T, None]:
        """Asks the server for the value once."""
        return self._object._gecos_call(self._method, [])

    def stream(self) -> Stream[T]:
        """Subscribes to the attribute. Raises ConnectionFailed or CommandFailed if this fails."""
        method = self._method
        code, name = method.operation.code, method.operation.name
        return _subscribed(self._object, code, name, method.result, method.in_place)


class Event(Unopened, Generic[T]):
    """An event of an object, for example `robot.touched`. `stream()` subscribes to it."""

    __slots__ = ("_event", "_object")

    def __init__(self, owner: Object, event: interface.Event[T]) -> None:
        self._object = owner
        self._event = event

    def _to_open(self) -> str:
        return _open_first(self._object, self._event.stream.name, "an event")

    def __call__(self, *_given: object, **_named: object) -> NoReturn:
        """Raises TypeError: only the server can send the event."""
        name = self._event.stream.name
        raise TypeError(
            f"{self._object!r}: {name} is an event, which the server sends; subscribe to it with "
            f"`.{name}.stream()`"
        )

    def __repr__(self) -> str:
        return f"<event {self._event.stream.name} of {self._object!r}>"

    def stream(self) -> Stream[T]:
        """Subscribes to the event. The samples of the stream are the events that the server sends
        after the subscription, each once and in order. A slow reader misses events, and so does a
        reader over lcm whose packets are lost. `Sample.lost` of the next event counts the missed
        events. Raises ConnectionFailed or CommandFailed if this fails."""
        event = self._event
        return _subscribed(self._object, event.stream.code, event.stream.name, event.result)


def _open_first(owner: Object, name: str, kind: str) -> str:
    return f"{owner!r}: {name} is {kind}; open it first with `.{name}.stream()`"


def _subscribed(
    owner: Object,
    code: int,
    name: str,
    decode: Callable[[Decoder], T],
    in_place: OctetsInPlace | None = None,
) -> Stream[T]:
    session = owner._gecos_session
    opened = session.subscribe(code)
    name = f"{session.object_name}.{name}"
    if isinstance(opened, tuple):
        detail, text = Detail(opened[0]), f"{name}: {opened[1]}"
        if detail.state is State.CONNECTION_FAILED:
            raise ConnectionFailed(detail, text)
        raise CommandFailed(detail, text)
    return Stream(opened, decode, name, in_place)


def demand_proxy(given: object, function: str, use: str = "{}(robot)") -> None:
    """Raises TypeError, which says what to write, unless `given` is a proxy. `function` is the name
    of the called function, and `use` shows its call."""
    if isinstance(given, Object):
        return
    name = given if isinstance(given, str) else "NAME"
    call = use.format(f"gecos.{function}")
    raise TypeError(
        f"gecos.{function} takes a proxy, not {given!r}: write `robot = gecos.dynamic({name!r})` "
        f"and `{call}`"
    )


def reference(proxy: Object) -> ObjectRef:
    """Returns a reference to the object, as a value for parameters and results whose type is an
    interface. In any process, `lab.create` makes a proxy from the reference."""
    from gecos_idl.object_ref_types import ObjectRef

    demand_proxy(proxy, "reference")
    return ObjectRef(*proxy._gecos_session.reference())


def with_deadline(proxy: P, seconds: float) -> P:
    """Returns a proxy of the same object. Calls through this proxy fail unless they complete within
    `seconds` after they are sent.

    If `seconds` is 0 or less, calls are not sent and end as EXPIRED. For example, `end -
    time.monotonic()` is negative after the time `end`. Raises ValueError unless `seconds` is a
    finite number.
    """
    demand_proxy(proxy, "with_deadline", "{}(robot, …)")
    if not math.isfinite(seconds):
        raise ValueError(
            f"a deadline must be a finite number of seconds, not {seconds}; for calls with only "
            "the deadline of their operation, use the original proxy"
        )
    twin = copy.copy(proxy)
    twin._gecos_deadline = seconds
    return twin
