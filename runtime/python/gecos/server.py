"""Runs servants: C++ accepts clients, queues and guards; two Python threads pull and answer."""

from __future__ import annotations

import itertools
import threading
import time
import traceback
from collections.abc import Iterable, Mapping
from types import TracebackType
from typing import Self

from gecos import _core, farewell, log
from gecos.ending import EndingSignals
from gecos.errors import DeclaredError, Detail, Interrupted, Rejected, ServeError
from gecos.execution import Execution
from gecos.interface import Handler
from gecos.lab import Lab
from gecos.servant import Servant
from gecos.wire import DecodeError, Decoder, to_bytes

_LANES = ("sensor", "fifo")  # as the extension numbers them
_LONGEST_TEXT = 10_000  # characters of a failure

BROKER_PATIENCE = 10.0
"""How long a server waits for a broker that is starting, in seconds."""
_PATIENCE_WITH_HANDLERS = 1.0  # s, until close() names the one that it waits for


class Server:
    """Serves objects until it is closed.

        with gecos.Server(lab) as server:
            server.add("LASER", Lds())

    One thread runs the handlers of sensor and safety operations, one all others in their order.
    """

    def __init__(self, lab: Lab) -> None:
        self._core = _core.Server(lab._core)
        self._servants: dict[int, Servant] = {}  # by their places, under which they are called
        self._places = itertools.count()
        # By lane, the servant and its call, or None for a stop.
        self._running: dict[int, tuple[Servant, _core.IncomingCall | None]] = {}
        self._adding = threading.Lock()
        self._threads = [
            threading.Thread(target=self._work, args=(lane,), name=f"gecos-{name}", daemon=True)
            for lane, name in enumerate(_LANES)
        ]
        for thread in self._threads:
            thread.start()
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
            place = next(self._places)  # nobody else's, also when this is broken off
            self._servants[place] = servant
            servant._gecos_core = self._core.prepare(place, servant._gecos_interface)
            try:
                if why := self._core.add(servant._gecos_core, name, simulated, list(media)):
                    raise ServeError(why)  # which names it
            except Exception:  # not Ctrl-C: then it may be served
                servant._gecos_core = None
                del self._servants[place]
                raise

    def close(self) -> None:
        """Withdraws all objects; running handlers are interrupted and waited for. One that does not
        look whether it is interrupted is named on stderr, and still waited for; a handler that
        closes its own server waits for none."""
        self._core.close()
        if threading.current_thread() in self._threads:
            return
        until = time.monotonic() + _PATIENCE_WITH_HANDLERS
        for thread in self._threads:
            thread.join(max(0.0, until - time.monotonic()))
        for lane, thread in enumerate(self._threads):
            if thread.is_alive():
                self._tell_running(lane)
        for thread in self._threads:
            thread.join()
        for servant in list(self._servants.values()):  # another thread may be adding
            servant._gecos_core = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _work(self, lane: int) -> None:
        while not self._core.closed:
            task = self._core.next(lane, None)
            if task is None:
                continue
            call, place = (None, task) if isinstance(task, int) else (task, task.servant)
            servant = self._servants.get(place)
            if servant is None:  # its add failed in the end
                continue
            self._running[lane] = servant, call
            if call is None:
                _stopped(servant)
            else:
                _answer(servant, call)
            self._running.pop(lane)

    def _tell_running(self, lane: int) -> None:
        running = self._running.get(lane)
        if running is None:
            return
        servant, call = running
        if call is not None:
            handler = servant._gecos_handlers.get(call.code)
            method = handler.method if handler else "?"
            advice = (
                "let it look at `run.interrupted`, or sleep in `run.wait_interrupted(…)`"
                if handler and handler.operation.cancelable
                else "make its operation @cancelable: only such a handler is told to end"
            )
        else:
            method = "gecos_on_stop"
            advice = "let it only say that all shall stop, and not wait until it has"
        log.error(
            "server",
            f"closing waits for the handler {type(servant).__name__}.{method}, which has not "
            f"returned; {advice}. The server is not closed until it returns",
        )


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


def _answer(servant: Servant, call: _core.IncomingCall) -> None:
    """Whatever the handler raises ends its call, not the thread of all calls."""
    handler = servant._gecos_handlers.get(call.code)
    if handler is None:
        call.fail(Detail.UNKNOWN_OPERATION, f"no operation has the code {call.code:#x}", "", b"")
        return
    try:
        arguments = handler.arguments(Decoder(call.arguments))
    except DecodeError as error:
        call.fail(Detail.BAD_PARAMETER, f"{handler.operation.name}: {error}", "", b"")
        return
    except BaseException as error:  # of a value type that a user wrote
        _fault(call, handler, error)
        return
    if call.interrupted():  # stopped or canceled while another handler had the thread
        call.fail(Detail.CANCELED, f"{handler.operation.name}: ended before it started", "", b"")
        return
    if handler.operation.cancelable:
        arguments = (*arguments, Execution(call))
    try:
        value = getattr(servant, handler.method)(*arguments)
        result = b"".join(handler.result(value))
    except BaseException as error:
        _raised(call, handler, error)
    else:
        call.finish(result)


def _raised(call: _core.IncomingCall, handler: Handler, error: BaseException) -> None:
    """Ends the call with what its handler raised, as far as that can be sent."""
    try:
        if isinstance(error, DeclaredError):
            call.fail(Detail.FAULT, _sendable(str(error)), error._gecos_name, to_bytes(error))
            return
        if isinstance(error, Rejected | Interrupted):
            call.fail(error.detail, _sendable(str(error.text)), "", b"")
            return
    except BaseException as unsendable:  # a member, or the text, of a type that it must not have
        unsendable.__cause__ = error
        error = unsendable
    _fault(call, handler, error)


def _fault(call: _core.IncomingCall, handler: Handler, error: BaseException) -> None:
    text = ": ".join(filter(None, (handler.operation.name, type(error).__name__, _text(error))))
    trace = "".join(traceback.format_exception(error))
    log.error("server", _sendable(f"{text}\n{trace}"))
    call.fail(Detail.FAULT, _sendable(text), "", b"")


def _text(error: BaseException) -> str:
    try:
        return str(error)
    except BaseException as unspeakable:
        return f"its text cannot be had: {type(unspeakable).__name__}"


def _sendable(text: str) -> str:
    """Half of a surrogate pair and NUL cannot be sent; a text of megabytes helps nobody."""
    text = text.encode(errors="backslashreplace").decode().replace("\0", "\\0")
    return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]} …"


def _stopped(servant: Servant) -> None:
    try:
        servant.gecos_on_stop()
    except BaseException:
        text = f"{servant._gecos_interface.name}: gecos_on_stop failed\n{traceback.format_exc()}"
        log.error("server", _sendable(text))
