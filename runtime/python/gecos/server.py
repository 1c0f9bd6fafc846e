"""Serves objects. C++ accepts clients, checks access and queues calls; Python runs the handlers."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Mapping
from types import TracebackType
from typing import Self

from gecos import _core, shutdown
from gecos.errors import ServeError
from gecos.handlers import LANES, Lane, check_handlers
from gecos.lab import Lab
from gecos.publisher import Publish, Publisher
from gecos.servant import Servant
from gecos.termination_signals import TerminationSignals

BROKER_PATIENCE = 10.0
"""How long a server waits for a broker that is starting, in seconds."""
_claiming = threading.Lock()  # guards `_gecos_core` of all servants
_PATIENCE_WITH_HANDLERS = 1.0  # s after which close() reports the handlers it waits for


class Server:
    """Serves objects until it is closed.

        with gecos.Server(lab) as server:
            server.add("LASER", Lds())

    Each object has three threads: one for the stop and the safety operations of the object, one for
    sensor operations that are neither cancelable nor ordered, and one for all other operations in
    order of arrival.

    `insecure=True` admits every user and host that the kernel or an admitted key proves: neither
    `allow` nor an [allow] of the lab file counts. Such a server serves simulated objects only, and
    says so on stderr, in its audit and in the descriptions of its objects. Set it only if a person
    asks for it by a flag of the program, never because of an environment variable.
    """

    def __init__(self, lab: Lab, *, insecure: bool = False) -> None:
        self._core = _core.Server(lab._core, insecure)
        self._lanes: list[Lane] = []
        self._adding = threading.Lock()
        shutdown.at_exit(self, shutdown.Turn.SERVERS)

    def allow(self, users: Iterable[str], hosts: Iterable[str] = ()) -> None:
        """Names the users and hosts that may connect to all objects of this server, in addition to
        the user of this process on this host. "*" admits every name.

        If the lab file also has a list for an object, both lists must admit a client. Applies to
        connections that are made after the call, and replaces the names of an earlier call. The
        server tells these names to the broker. If no list of the broker's lab file admits a named
        user, this user may then ask the broker for the objects of this server, and for nothing
        else. Does not lower the status that an operation needs. Raises ValueError if there are more
        than 256 users or more than 256 hosts, or if a name is empty, or has more than 256 bytes or
        a control character.
        """
        self._core.allow(_names("users", users), _names("hosts", hosts))

    def await_broker(self, patience: float = BROKER_PATIENCE) -> None:
        """Waits at most `patience` seconds for a broker that is starting. `add` waits as well.

        If no broker answers, raises ServeError, which says where the broker was expected.
        """
        if why := self._core.await_broker(patience):
            raise ServeError(why)

    def add(
        self, name: str, servant: Servant, *, simulated: bool = False, media: Iterable[str] = ()
    ) -> None:
        """Serves `servant` under `name` from now on. `media` lists the media that clients may use;
        an empty list means all media.

        Raises ServeError if no broker answers, the name is taken, no medium can be opened, or an
        insecure server is to serve an object that is not simulated. Raises
        TypeError if a handler does not take the parameters of its operation.
        """
        if not isinstance(servant, Servant):
            given = f"the class {servant.__name__}" if isinstance(servant, type) else repr(servant)
            raise TypeError(
                f"{name}: the servant must be an object of a class that derives from a generated "
                f"…Servant, not {given}"
            )
        if isinstance(media, str):
            raise TypeError(f"{name}: media must be a list of names: `media=[{media!r}]`")
        check_handlers(servant)
        self.await_broker()
        with self._adding:
            prepared = self._core.prepare(servant._gecos_interface)
            lanes = [Lane(self, name, servant, prepared, lane) for lane in range(len(LANES))]
            # New lanes are registered before they start, so that close() waits for them. Lanes that
            # have ended are removed.
            self._lanes = [*filter(Lane.is_alive, self._lanes), *lanes]
            may_be_served = False
            try:
                _claim(servant, prepared, name)
                _start(lanes, name)
                may_be_served = True
                if why := self._core.add(prepared, name, simulated, list(media)):
                    raise ServeError(why)  # `why` already contains the name of the object
            except BaseException as error:
                # A servant that cannot be served is released and its lanes end. If
                # KeyboardInterrupt arrives while the servant may already be served, the object
                # remains served.
                if not may_be_served or isinstance(error, Exception):
                    _release(servant, prepared)
                    self._core.forget(prepared)  # ends the lanes of the servant
                raise

    def close(self) -> None:
        """Withdraws all objects, interrupts running handlers and waits until they return. After 1
        s, `close` writes the names of the handlers that still run to stderr, and keeps waiting for
        them. If a handler closes its own server, `close` waits for no handler."""
        self._core.close()
        # Only lanes that were started can be joined.
        lanes = [lane for lane in self._lanes if lane.ident is not None]
        if threading.current_thread() in lanes:
            for lane in lanes:
                _release(lane.servant, lane.core)
            return
        until = time.monotonic() + _PATIENCE_WITH_HANDLERS
        for lane in lanes:
            lane.join(max(0.0, until - time.monotonic()))
        for lane in lanes:
            if lane.is_alive():
                lane.tell_running()
        for lane in lanes:
            lane.join()
            _release(lane.servant, lane.core)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _names(what: str, names: Iterable[str]) -> list[str]:
    if isinstance(names, str):
        raise TypeError(f"{what} must be a list of names; write `{what}=[{names!r}]`")
    return list(names)


def _claim(servant: Servant, prepared: _core.PulledServant, name: str) -> None:
    with _claiming:
        if servant._gecos_core is not None:
            raise ServeError(
                f"{name}: this {type(servant).__name__} is served already under another name, and "
                "a servant can publish under one name only; create a servant for each name"
            )
        servant._gecos_core = prepared


def _release(servant: Servant, prepared: _core.PulledServant) -> None:
    """Clears `_gecos_core` of the servant, unless another server has claimed the servant in the
    meantime."""
    with _claiming:
        if servant._gecos_core is prepared:
            servant._gecos_core = None


def _start(lanes: Iterable[Lane], name: str) -> None:
    try:
        for lane in lanes:
            lane.start()
    except RuntimeError as error:
        raise ServeError(f"{name}: cannot start its handler threads: {error}") from None


def serve(
    servants: Mapping[str, Servant],
    *,
    simulated: bool = False,
    lab: Lab | None = None,
    media: Iterable[str] = (),
    users: Iterable[str] = (),
    hosts: Iterable[str] = (),
    insecure: bool = False,
    publish: Publish | None = None,
) -> None:
    """Serves objects under their names until SIGINT or SIGTERM arrives. Call it from the main
    thread.

    `users` and `hosts` may connect, in addition to the user of this process on this host; see
    `Server.allow`. `insecure=True` admits every user and host to simulated objects; see `Server`.

    Raises ValueError without a servant, and TypeError if `servants` is not a mapping.

    `publish(ended)` runs on a thread of its own while the objects are served: it measures and
    publishes until the event `ended` is set. If `publish` raises an exception, `serve` ends and
    raises it again.
    """
    if threading.current_thread() is not threading.main_thread():
        raise RuntimeError(
            "call gecos.serve from the main thread, because only that thread receives signals; in "
            "another thread use `with gecos.Server(lab) as server: server.add(…)`"
        )
    if not isinstance(servants, Mapping):
        raise TypeError(
            f"gecos.serve takes servants by their names: write gecos.serve({{'NAME': servant}}), "
            f"not {servants!r}"
        )
    if not servants:
        raise ValueError("gecos.serve was given no servant: write gecos.serve({'NAME': servant})")
    # TerminationSignals must be the inner context. Then a signal that arrives while the server
    # closes ends the program, even if a handler or `publish` hangs.
    with (
        Server(lab or Lab(), insecure=insecure) as server,
        Publisher() as publisher,
        TerminationSignals() as signals,
    ):
        allowed = _names("users", users), _names("hosts", hosts)
        if any(allowed):
            server.allow(*allowed)
        if not _broker_found(server, signals):
            return
        for name, servant in servants.items():
            server.add(name, servant, simulated=simulated, media=media)
        if publish is not None:
            publisher.start(publish, signals.end_wait)
        print(f"serving {', '.join(servants)}", flush=True)
        signals.wait()


def _broker_found(server: Server, signals: TerminationSignals) -> bool:
    """Waits for a broker. Returns False if a termination signal arrives first."""
    give_up = time.monotonic() + BROKER_PATIENCE
    while not signals.came():
        try:
            server.await_broker(min(0.2, give_up - time.monotonic()))
        except ServeError:
            if time.monotonic() >= give_up:
                raise
        else:
            return True
    return False
