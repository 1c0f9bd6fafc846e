"""Proxies for programs that run longer than the servers that they use."""

from __future__ import annotations

import contextlib
import copy
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Generic, Self, TypeVar, Unpack, cast

from gecos.errors import (
    Attempt,
    CommandFailed,
    ConnectionFailed,
    CreateError,
    DeclaredError,
    Detail,
    StreamLost,
)
from gecos.lab import CreateOptions, Lab, table_of
from gecos.proxy import Object

P = TypeVar("P", bound=Object)
R = TypeVar("R")
FAILURES = (CreateError, CommandFailed, ConnectionFailed)
"""The failures of an attempt to create a proxy or to open a stream."""
# The failures of a command whose server was lost while the command ran.
_SERVER_LOST = (Detail.SERVER_CRASHED, Detail.OUTCOME_UNKNOWN)


class Reconnecting(Generic[P]):
    """A proxy that is created at its first use, and created again after its server was lost.

        oven = gecos.Reconnecting(lab, Oven, "OVEN")
        oven.call(lambda there: there.temperature().result())

    A Reconnecting may be made before its object is online. `interface` is a class that gidl
    generated, or `gecos.DynamicObject`: then each proxy is made from the model of its server, as
    `lab.dynamic` does. `between_tries` is the pause in s after a failed attempt to create the
    proxy. The other parameters have the same meaning as in `lab.create`.

    Only the connection is renewed. A new proxy has no status: a lease ends with its session, and
    the program must acquire the status again. A command that was running ends as without a
    Reconnecting; `gecos.outcome(oven.get(), command.id)` asks the server what became of it.
    Thread-safe: threads may share one Reconnecting, and get the same proxy.
    """

    def __init__(
        self,
        lab: Lab,
        interface: type[P],
        name: str,
        *,
        wait: float = 0.0,
        between_tries: float = 0.5,
        **create: Unpack[CreateOptions],
    ) -> None:
        self._source = Source(lab, interface, name, create)
        self._wait = wait
        self._between_tries = between_tries
        self._lock = threading.Lock()  # held while connecting; guards the members below
        self._proxy: P | None = None
        self._problem: CreateError | CommandFailed | ConnectionFailed | None = None
        self._next_try = 0.0
        self._closed = False

    @property
    def name(self) -> str:
        return self._source.name

    def get(self) -> P:
        """Returns the proxy. If there is no proxy, creates one: this takes at most `wait` plus
        `patience`, and other threads that call `get` wait meanwhile. After a failed attempt, makes
        no new attempt for the time `between_tries`, and raises the error of the failure at once.

        Returns a proxy whose server was lost until `call` or the program drops it. Raises
        CreateError. With `gecos.DynamicObject`, also raises CommandFailed and ConnectionFailed.
        """
        with self._lock:
            if self._proxy is None:
                self._proxy = self._created()
            return self._proxy

    def call(self, call: Callable[[P], R]) -> R:
        """Calls `call` with the proxy and returns its result. The function `call` issues a command
        through the proxy, waits until the command has ended, and returns its result. Drops the
        proxy when the server was lost, so that the next `get` creates a new one. When the command
        certainly did not start (ConnectionFailed), repeats `call` once, through a new proxy. A
        function that issues several commands is repeated as a whole.

        Raises the exceptions of `call`. Raises ConnectionFailed, too, if there is no proxy.
        """
        with contextlib.suppress(ConnectionFailed):
            return self._call_once(call)
        return self._call_once(call)

    def drop(self, lost: P) -> None:
        """Drops the proxy `lost`, so that the next `get` creates a new one. Does nothing if another
        proxy has already replaced `lost`."""
        with self._lock:
            dropped = self._proxy
            if dropped is not None and dropped._gecos_session is lost._gecos_session:
                self._proxy = None

    def close(self) -> None:
        """Drops the proxy. A later `get` raises CreateError. If another thread creates the proxy,
        waits for that thread."""
        with self._lock:
            self._closed = True
            self._proxy = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _created(self) -> P:
        if self._closed:
            raise _unreachable(self.name, "this Reconnecting is closed; make a new one")
        if self._problem is not None and time.monotonic() < self._next_try:
            raise copy.copy(self._problem)
        try:
            return self._source.connect(self._wait)
        except FAILURES as error:
            self._problem = copy.copy(error)  # without the traceback, which keeps its frames alive
            self._next_try = time.monotonic() + self._between_tries
            raise

    def _call_once(self, call: Callable[[P], R]) -> R:
        try:
            proxy = self.get()
        except FAILURES as error:
            raise ConnectionFailed(Detail.NO_SERVER, str(error)) from error
        try:
            return call(proxy)
        except DeclaredError:
            raise
        except CommandFailed as error:
            if error.detail in _SERVER_LOST:
                self.drop(proxy)
            raise
        except (ConnectionFailed, StreamLost):
            self.drop(proxy)
            raise


@dataclass(frozen=True, slots=True)
class Source(Generic[P]):
    """An object, and how a Lab connects to it."""

    lab: Lab
    interface: type[P]
    name: str
    create: CreateOptions

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(f"the name of an object must be a text, not {self.name!r}")
        unknown = sorted(set(self.create) - set(CreateOptions.__annotations__))
        if unknown:
            raise TypeError(f"{self.name}: {', '.join(unknown)}: `lab.create` has no such argument")
        typed = sorted(set(self.create) - {"medium", "patience"})
        if self._is_dynamic() and typed:
            raise TypeError(
                f"{self.name}: {', '.join(typed)}: only a class that gidl generated has these"
            )

    def connect(self, wait: float) -> P:
        """Returns a new proxy. Raises CreateError; a dynamic proxy also raises CommandFailed and
        ConnectionFailed."""
        try:
            return self._dynamic(wait) if self._is_dynamic() else self._generated(wait)
        except ValueError:
            if self.lab._closed:
                raise _unreachable(self.name, "this Lab is closed; make a new one") from None
            raise

    def _generated(self, wait: float) -> P:
        return self.lab.create(self.interface, self.name, wait=wait, **self.create)

    def _is_dynamic(self) -> bool:
        """Returns whether `interface` has no interface of its own, as gecos.DynamicObject."""
        return table_of(self.interface) is Object._gecos_interface

    def _dynamic(self, wait: float) -> P:
        from gecos.dynamic_client import ModelError

        try:
            made = self.lab.dynamic(
                self.name,
                medium=self.create.get("medium"),
                patience=self.create.get("patience", 2.0),
                wait=wait,
            )
        except ModelError as error:
            raise CreateError([Attempt(self.name, Detail.REFUSED, str(error))]) from error
        return cast(P, made)


def _unreachable(name: str, why: str) -> CreateError:
    return CreateError([Attempt(name, Detail.NO_SERVER, why)])
