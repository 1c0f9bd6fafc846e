"""The implementation of an object: a generated skeleton derives from `Servant`, and the user's
class derives from the skeleton.

gidl generates code such as this for a server:

    class ManipulatorServant(DeviceServant):
        _gecos_interface = _MANIPULATOR
        _gecos_handlers = _MANIPULATOR.handlers

        @abstractmethod
        def move(
            self, goal: Frame, how: Trajectory | None, run: Execution[MotionProgress]
        ) -> None: …

        @abstractmethod
        def tool(self) -> Frame: …

        def publish_tool(self, value: Frame, stamp: float | None = None) -> None:
            self._gecos_publish(0x…, _TOOL.body(value), stamp)
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from gecos import interface
from gecos.errors import ServeError
from gecos.in_place import Loan
from gecos.interface import Handler, Interface, Method
from gecos.inward import Inward
from gecos.stamp import in_ns
from gecos.wire import Parts

if TYPE_CHECKING:
    from gecos import _core


T = TypeVar("T")


class Servant(ABC):  # noqa: B024  # the skeletons declare the abstract methods
    """The base class of servants. A handler may raise a declared exception of its operation,
    `gecos.Rejected` or `gecos.Interrupted`. Any other exception becomes a FAULT and is logged.

    Each object has three threads, and each thread calls one handler at a time. One thread is for
    safety operations, one for sensor operations that are neither cancelable nor ordered, and one
    for all other operations.
    """

    _gecos_interface: ClassVar[Interface] = Interface(name="gecos::Object")
    _gecos_handlers: ClassVar[Mapping[int, Handler]] = {}
    _gecos_core: _core.PulledServant | None = None  # None unless the servant is served

    def gecos_on_stop(self) -> None:  # noqa: B027  # most servants watch run.interrupted instead
        """Called when a client stops the object. Override this method to halt the device. The
        method runs on the thread of the safety operations while other handlers may still run. The
        leases have already ended, and the queue is empty."""

    def _gecos_inward(self, stream: interface.Inward[T]) -> Inward[T]:
        opened: dict[int, Inward[Any]] = self.__dict__.setdefault("_gecos_inward_streams", {})
        return opened.setdefault(stream.stream.code, Inward(self, stream))

    def _gecos_publish(self, code: int, sample: Parts, stamp: float | None) -> None:
        core = self._gecos_core  # read once, because closing the server clears it
        if core is None:
            raise _not_served(self)
        core.publish(code, b"".join(sample), in_ns(stamp))

    def _gecos_lend(self, method: Method[T, None], value: T, octets: int) -> Loan:
        assert method.in_place is not None
        core = self._gecos_core  # read once, because closing the server clears it
        if core is None:
            raise _not_served(self)
        if octets < 0:
            raise ValueError(f"{method.operation.name}: {octets} octets; give 0 or more")
        head, tail = method.in_place.encode(value, octets)
        lent = core.lend(method.operation.code, head, octets, tail)
        if lent is None:
            raise _not_served(self)
        return Loan(lent)


def _not_served(servant: Servant) -> ServeError:
    return ServeError(
        f"{servant._gecos_interface.name}: a servant cannot publish while it is not served; "
        "add it to a gecos.Server first (a closed server serves nothing)"
    )
