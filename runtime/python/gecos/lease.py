"""Leases: actor or master status of a device, usually for the duration of a `with` block."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from types import TracebackType
from typing import Self

from gecos import _core, shutdown
from gecos.errors import ConnectionFailed, Detail, DroppedLeaseWarning, LeaseRefused, State
from gecos.interface import Access
from gecos.proxy import Object, demand_proxy
from gecos.wire import DecodeError, from_bytes


class Lease:
    """Actor or master status of one object. It is held until the lease is released or lost, or the
    program ends.

    Commands that were issued under the lease still finish after its release, before another client
    gets the status. Once `release` has returned, the server refuses later commands (DENIED).
    """

    def __init__(self, core: _core.Lease, object_name: str) -> None:
        self._core = core
        self._object_name = object_name
        self._released = False
        self.__class__ = _Untouched
        shutdown.at_exit(self, shutdown.Turn.LEASES)

    @property
    def epoch(self) -> int:
        """The epoch (fencing token) of the lease."""
        return self._core.epoch

    def release(self) -> None:
        """Releases the status; queued and running commands still finish. A second call has no
        effect."""
        self.__class__ = Lease
        self._released = True
        self._core.release()

    close = release

    def release_now(self) -> None:
        """Releases the status, and stops the queued and running commands that were issued under
        it."""
        self.__class__ = Lease
        self._released = True
        self._core.release_now()

    def __enter__(self) -> Self:
        self.__class__ = Lease  # type: ignore[assignment]
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()

    def __repr__(self) -> str:
        status = Access(self._core.status).name
        return f"<Lease {status} of {self._object_name}: {self._state()}, epoch {self.epoch:#x}>"

    def _state(self) -> str:
        """Returns the state of the lease as far as this program knows it. If another client has
        stopped the object, this program learns of this only when one of its commands ends."""
        if self._released:
            return "released"
        return "lost" if self._core.lost() else "acquired, not released"


class _Untouched(Lease):
    """A lease that was neither entered nor released. Only this class has a `__del__`, because a
    Ctrl-C during a `__del__` is lost."""

    def __del__(self) -> None:
        if self._core.fresh():
            function = Access(self._core.status).name.lower()
            warnings.warn(
                f"{function} status of {self._object_name} was released at once, before any "
                f"command was issued under it; write `with gecos.{function}(…):`",
                DroppedLeaseWarning,
                stacklevel=2,
            )


def actor(
    robot: Object,
    password: str = "",
    *,
    timeout: float | None = 0.0,
    on_position: Callable[[int], object] | None = None,
) -> Lease:
    """Acquires actor status, which commands that move or change the device need. Clients with the
    same `password` may share the status.

    While other clients hold the status, the request waits for `timeout` s, in the order of arrival.
    A `timeout` of None waits without limit, and 0 does not wait. `on_position(before)` is called
    with the number of requests before this one, when the wait begins and whenever the number
    changes. A `stop` of the object ends all waiting requests. A server that was built before
    `timeout` existed refuses the request at once.

    Raises LeaseRefused, which lists the holders, or ConnectionFailed.
    """
    return _acquire(robot, Access.ACTOR, password, timeout, on_position)


def master(
    robot: Object,
    password: str = "",
    *,
    timeout: float | None = 0.0,
    on_position: Callable[[int], object] | None = None,
) -> Lease:
    """Acquires master status. Master status gives the rights of actor status. The object also
    refuses the calls of all other clients."""
    return _acquire(robot, Access.MASTER, password, timeout, on_position)


def _acquire(
    robot: Object,
    access: Access,
    password: str,
    timeout: float | None,
    on_position: Callable[[int], object] | None,
) -> Lease:
    demand_proxy(robot, access.name.lower(), "with {}(robot):")
    session = robot._gecos_session
    asked = session.ask_for_status(access, password, math.inf if timeout is None else timeout)
    try:
        _await_reply(asked, on_position)
    except BaseException:
        session.decline_status(asked)
        raise
    got = session.lease(asked)
    if isinstance(got, _core.Lease):
        return Lease(got, session.object_name)
    number, text, exception, evidence = got
    detail = Detail(number)
    where = f"{access.name.lower()} status of {session.object_name}"
    if detail.state is State.CONNECTION_FAILED:
        raise ConnectionFailed(detail, f"{where}: {text}")
    if detail in (Detail.SERVER_CRASHED, Detail.OUTCOME_UNKNOWN):
        lost = f"{where} was not granted: the server was lost while the request waited: {text}"
        raise ConnectionFailed(Detail.NO_SERVER, lost)
    raise _refusal(where, text, exception, evidence)


def _await_reply(asked: _core.Command, on_position: Callable[[int], object] | None) -> None:
    """Waits until the request `asked` has a reply. While the request waits in line, calls
    `on_position` with the number of requests before it, and again when this number changes."""
    if on_position is None:
        asked.wait(None)
        return
    reported = None
    # `wait` does not return when only the position in the line changes, so each wait is short.
    while not asked.wait(0.05):
        detail, position, _ = asked.progress()
        if detail == Detail.QUEUED and position != reported:
            reported = position
            on_position(position)


def _refusal(where: str, text: str, exception: str, evidence: bytes) -> LeaseRefused:
    from gecos_idl.object_types import StatusRefused

    if exception != StatusRefused._gecos_name:
        return LeaseRefused(f"{where}: {text}")
    try:
        refused = from_bytes(StatusRefused, evidence)
    except DecodeError as error:
        return LeaseRefused(f"{where}: {text} (the list of holders cannot be decoded: {error})")
    # The reason already names the object and the status.
    return LeaseRefused(refused.reason, refused.holders)
