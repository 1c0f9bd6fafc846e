"""Serves objects: C++ accepts clients, queues and guards; Python threads pull and answer."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Mapping
from types import TracebackType
from typing import Self

from gecos import _core, farewell
from gecos.ending import EndingSignals
from gecos.errors import ServeError
from gecos.handlers import LANES, Lane
from gecos.lab import Lab
from gecos.servant import Servant

BROKER_PATIENCE = 10.0
"""How long a server waits for a broker that is starting, in seconds."""
_PATIENCE_WITH_HANDLERS = 1.0  # s, until close() names the one that it waits for


class Server:
    """Serves objects until it is closed.

        with gecos.Server(lab) as server:
            server.add("LASER", Lds())

    Each object has two threads: one runs the handlers of its sensor and safety operations, one
    all others in their order.
    """

    def __init__(self, lab: Lab) -> None:
        self._core = _core.Server(lab._core)
        self._lanes: list[Lane] = []
        self._adding = threading.Lock()
        farewell.at_exit(self, farewell.Turn.SERVERS)

    def await_broker(self, patience: float = BROKER_PATIENCE) -> None:
        """Waits at most `patience` seconds for a broker that is starting; `add` does this too.

        Raises ServeError that says where it was looked for.
        """
        if why := self._core.await_broker(patience):
            raise ServeError(why)

    def add(
        self, name: str, servant: Servant, *, simulated: bool = False, media: Iterable[str] = ()
    ) -> None:
        """Serves `servant` under `name` from now on. `media`: those that clients may use, else all.

        Raises ServeError when no broker answers, the name is taken or nothing can be opened.
        """
        if not isinstance(servant, Servant):
            given = f"the class {servant.__name__}" if isinstance(servant, type) else repr(servant)
            raise TypeError(
                f"{name}: what is served is an object of a class that you derived from a generated "
                f"…Servant, not {given}"
            )
        self.await_broker()
        with self._adding:
            if servant._gecos_core is not None:
                raise ServeError(
                    f"{name}: this {type(servant).__name__} is served already under another name, "
                    "and would publish for one of them only; make one for each object"
                )
            prepared = servant._gecos_core = self._core.prepare(servant._gecos_interface)
            try:
                self._start_lanes(name, servant, prepared)
                if why := self._core.add(prepared, name, simulated, list(media)):
                    raise ServeError(why)  # which names it
            except Exception:  # not Ctrl-C: then it may be served
                servant._gecos_core = None
                self._core.forget(prepared)  # which ends its lanes
                self._lanes = [lane for lane in self._lanes if lane.servant is not servant]
                raise

    def _start_lanes(self, name: str, servant: Servant, prepared: _core.PulledServant) -> None:
        for number in range(len(LANES)):
            lane = Lane(self, name, servant, prepared, number)
            try:
                lane.start()
            except RuntimeError as error:
                raise ServeError(f"{name}: no thread for its handlers: {error}") from None
            self._lanes.append(lane)

    def close(self) -> None:
        """Withdraws all objects; running handlers are interrupted and waited for. One that does not
        look whether it is interrupted is named on stderr, and still waited for; a handler that
        closes its own server waits for none."""
        self._core.close()
        lanes = list(self._lanes)  # another thread may be adding
        if threading.current_thread() in lanes:
            return
        until = time.monotonic() + _PATIENCE_WITH_HANDLERS
        for lane in lanes:
            lane.join(max(0.0, until - time.monotonic()))
        for lane in lanes:
            if lane.is_alive():
                lane.tell_running()
        for lane in lanes:
            lane.join()
            lane.servant._gecos_core = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def serve(
    servants: Mapping[str, Servant],
    *,
    simulated: bool = False,
    lab: Lab | None = None,
    media: Iterable[str] = (),
) -> None:
    """Serves objects under their names until SIGINT or SIGTERM. Call it from the main thread."""
    if threading.current_thread() is not threading.main_thread():
        raise RuntimeError(
            "gecos.serve waits for signals, which the main thread alone gets; in another one use "
            "`with gecos.Server(lab) as server: server.add(…)`"
        )
    with EndingSignals() as signals, Server(lab or Lab()) as server:
        if not _broker_found(server, signals):
            return
        for name, servant in servants.items():
            server.add(name, servant, simulated=simulated, media=media)
        print(f"serving {', '.join(servants)}", flush=True)
        signals.wait()


def _broker_found(server: Server, signals: EndingSignals) -> bool:
    """Waits for it, but not after the user has had enough."""
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
