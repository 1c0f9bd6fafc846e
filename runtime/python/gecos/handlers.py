"""The threads that run the handlers of a servant, and send results and exceptions to the
callers."""

from __future__ import annotations

import inspect
import threading
import traceback
from typing import TYPE_CHECKING, Literal

from gecos import _core, log
from gecos.errors import DeclaredError, Detail, Interrupted, Rejected
from gecos.execution import Execution
from gecos.interface import Handler
from gecos.servant import Servant
from gecos.wire import DecodeError, Decoder, to_bytes

if TYPE_CHECKING:
    from gecos.server import Server

LANES = ("safety", "sensor", "fifo")  # same order as in `Lane` of pulled_servant.hpp
_LONGEST_TEXT = 10_000  # maximum length of the text of a failure, in characters


class Lane(threading.Thread):
    """The thread of one lane of a servant. It runs the handlers of the lane one after another,
    until the lane is closed."""

    def __init__(
        self, server: Server, name: str, servant: Servant, core: _core.PulledServant, lane: int
    ) -> None:
        super().__init__(name=f"gecos-{LANES[lane]}-{name}", daemon=True)
        self._server = server  # so that a running thread keeps its server alive
        self.servant = servant
        self.core = core
        self._object_name = name
        self._lane = lane
        self._running: _core.IncomingCall | Literal["stopped"] | None = None

    def run(self) -> None:
        while (task := self.core.next(self._lane)) is not None:
            self._running = task
            if task == "stopped":
                _stopped(self.servant, self._object_name)
            else:
                _answer(self.servant, task, self._object_name)
            self._running = None

    def tell_running(self) -> None:
        """Writes to stderr which handler the server's `close()` waits for."""
        running = self._running
        if running is None:
            return
        if running != "stopped":
            handler = self.servant._gecos_handlers.get(running.code)
            method = handler.method if handler else "?"
            advice = (
                "check `run.interrupted` in the handler, or sleep in `run.wait_interrupted(…)`"
                if handler and handler.operation.cancelable
                else "make the operation @cancelable, so that its handler can be interrupted"
            )
        else:
            method = "gecos_on_stop"
            advice = "gecos_on_stop must only request the stop, and must not wait for its end"
        log.error(
            "server",
            f"closing waits for the handler {type(self.servant).__name__}.{method}, which has "
            f"not returned; {advice}. The server is not closed until it returns; "
            "another SIGINT or SIGTERM ends the program",
        )


def check_handlers(servant: Servant) -> None:
    """Raises TypeError if a handler does not take the parameters of its operation."""
    for handler in servant._gecos_handlers.values():
        if handler.parameters is None:
            continue
        words = [*handler.parameters, *(["run"] if handler.operation.cancelable else [])]
        try:
            takes = inspect.signature(getattr(servant, handler.method))
        except ValueError:  # the callable is not written in Python
            continue
        try:
            takes.bind(*words)
        except TypeError:
            declared = ", ".join(["self", *words])
            why = "; its operation is @cancelable, so `run` is its last parameter"
            raise TypeError(
                f"{type(servant).__name__}.{handler.method} takes {takes}, which does not fit its "
                f"operation: write `def {handler.method}({declared})`"
                f"{why if handler.operation.cancelable else ''}"
            ) from None


def _answer(servant: Servant, call: _core.IncomingCall, name: str) -> None:
    """Runs the handler of `call` and replies. An exception ends the call, not the lane's thread."""
    handler = servant._gecos_handlers.get(call.code)
    if handler is None:
        call.fail(Detail.UNKNOWN_OPERATION, f"no operation has the code {call.code:#x}", "", b"")
        return
    try:
        arguments = handler.arguments(Decoder(call.arguments))
    except DecodeError as error:
        call.fail(Detail.BAD_PARAMETER, f"{handler.operation.name}: {error}", "", b"")
        return
    except BaseException as error:  # raised by a hand-written value type
        what = f"the arguments of '{handler.operation.name}' cannot be read: "
        _fault(call, name, what + _named(error), error)
        return
    if call.interrupted():  # stopped or canceled while another handler occupied the thread
        call.fail(
            Detail.CANCELED,
            f"'{handler.operation.name}' was stopped or canceled before it started",
            "",
            b"",
        )
        return
    if handler.operation.cancelable:
        arguments = (*arguments, Execution(call, handler.feedback))
    try:
        value = getattr(servant, handler.method)(*arguments)
    except BaseException as error:
        _raised(call, handler, name, error)
        return
    try:
        result = b"".join(handler.result(value))
    except BaseException as error:
        what = f"the handler of '{handler.operation.name}' returned a value that cannot be sent: "
        _fault(call, name, what + _named(error), error)
    else:
        call.finish(result)


def _raised(
    call: _core.IncomingCall, handler: Handler, object_name: str, error: BaseException
) -> None:
    """Ends the call as failed. If possible, sends the exception that its handler raised."""
    raised = f"the handler of '{handler.operation.name}' raised "
    try:
        declared = (DeclaredError,) if handler.raises is None else handler.raises
        if isinstance(error, declared):
            call.fail(Detail.FAULT, _sendable(str(error)), error._gecos_name, to_bytes(error))
            return
        if isinstance(error, Interrupted) and not call.interrupted():
            what = (
                f"{raised}Interrupted, but nothing interrupted it; to refuse a call, raise "
                "gecos.Rejected(why)"
            )
            _fault(call, object_name, what, error)
            return
        if isinstance(error, Rejected | Interrupted):
            call.fail(error.detail, _sendable(str(error.text)), "", b"")
            return
    except BaseException as unsendable:  # a member or the text has a wrong type
        unsendable.__cause__ = error
        what = f"{raised}{type(error).__name__}, which cannot be sent: {_named(unsendable)}"
        _fault(call, object_name, what, unsendable)
        return
    what = f"{raised}{type(error).__name__}, which it does not declare"
    _fault(call, object_name, ": ".join(filter(None, (what, _text(error)))), error)


def _fault(call: _core.IncomingCall, object_name: str, text: str, error: BaseException) -> None:
    log.error("server", _sendable(f"{object_name}: {text}\n{_trace(error)}"))
    call.fail(Detail.FAULT, _sendable(text), "", b"")


def _named(error: BaseException) -> str:
    return ": ".join(filter(None, (type(error).__name__, _text(error))))


def _text(error: BaseException) -> str:
    try:
        return str(error)
    except BaseException as unspeakable:
        return f"str() of the exception raised {type(unspeakable).__name__}"


def _trace(error: BaseException) -> str:
    try:
        return "".join(traceback.format_exception(error))
    except BaseException as unspeakable:  # raised by the notes or the causes of `error`
        return f"formatting the traceback raised {type(unspeakable).__name__}"


def _sendable(text: str) -> str:
    """Replaces lone surrogates and NUL, which cannot be sent, and shortens very long texts."""
    text = text.encode(errors="backslashreplace").decode().replace("\0", "\\0")
    return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]} …"


def _stopped(servant: Servant, name: str) -> None:
    try:
        servant.gecos_on_stop()
    except BaseException as error:
        text = f"{name}: gecos_on_stop failed\n{_trace(error)}"
        log.error("server", _sendable(text))
