"""A call that a server judged, until its reply is sent."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .packets import Detail, Failure, Kind, Packet, Progress, Status

if TYPE_CHECKING:
    from .served import Session


@dataclass(frozen=True, slots=True)
class Operation:
    """What an object can do. Without a handler, whoever runs the server ends the task."""

    name: str
    code: int
    hash: int
    status: Status
    cancelable: bool = False
    handler: Callable[[Task], None] | None = None

    @property
    def queued(self) -> bool:
        return self.status != Status.SENSOR


class Task:
    """It waits, runs, is over. Ended once: later words of its handler count no more."""

    def __init__(self, session: Session, operation: Operation, call: Packet, age_ns: float) -> None:
        self.session = session
        self.operation = operation
        self.call = call
        self.detail = Detail.QUEUED
        self.fraction = 0.0
        self.feedback = b""
        self.canceled = False
        self.over = False
        self.before: Callable[[Task], int] = lambda task: 0
        """How many stand before it in the queue."""
        self.resumed_in: list[tuple[Session, Packet]] = []
        """Who asked for it again in another session, and how."""
        self.on_end: Callable[[Task], None] = lambda task: None
        left = (call.deadline_ns - age_ns) * 1e-9
        self.end_at = time.monotonic() + left if call.deadline_ns else None

    @property
    def parameters(self) -> bytes:
        return self.call.body

    @property
    def waits(self) -> bool:
        return self.detail == Detail.QUEUED and not self.over

    def start(self) -> None:
        self.detail = Detail.EXECUTING
        if self.operation.handler:
            self.operation.handler(self)
        if self.operation.cancelable and not self.over:
            self.tell()

    def cancel(self) -> None:
        if self.waits:
            self.fail(Detail.CANCELED, "it waited")
        elif self.operation.cancelable and not self.over:
            self.detail = Detail.CANCELING
            self.canceled = True
            self.tell()

    def progress(self, fraction: float, feedback: bytes = b"") -> None:
        self.fraction, self.feedback = fraction, feedback
        self.tell()

    def standing(self) -> Packet:
        body = Progress(self.before(self), self.fraction, self.feedback).pack()
        return Packet(Kind.PROGRESS, self.detail, counter=self.call.counter, body=body)

    def tell(self) -> None:
        if not self.over:
            self.session.send(self.standing())

    def done(self, body: bytes = b"") -> None:
        self.reply(Packet(Kind.REPLY, Detail.DONE, body=body))

    def fail(self, detail: Detail, text: str, exception: str = "", value: bytes = b"") -> None:
        self.reply(Packet(Kind.REPLY, detail, body=Failure(text, exception, value).pack()))

    def reply(self, reply: Packet) -> None:
        if self.over:
            return
        self.over = True
        self.detail = Detail(reply.detail) if reply.detail in list(Detail) else Detail.FAULT
        reply = replace(reply, counter=self.call.counter)
        self.session.replies.keep(reply)
        self.session.send(reply)
        for session, call in self.resumed_in:
            session.answer(call, reply)
        self.on_end(self)

    def look_at_clock(self, now: float) -> None:
        if self.end_at is None or now < self.end_at or self.over:
            return
        late = Detail.EXPIRED if self.waits else Detail.TIMED_OUT
        self.fail(late, f"{self.operation.name}: its deadline passed")
