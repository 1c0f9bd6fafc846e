"""A server's place: handshakes, and the connections that come of them."""

from __future__ import annotations

import secrets
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from .frames import HEADER, Frame, Header, Inner, Kind, SealedConnection
from .lcm import Ear, Loop, parse_place, place_of
from .noise import Accepted, Keys, accept

REMEMBERED_S = 5.0
REMEMBERED = 4096
SILENT_S = 1.5
FIRST_SIZE = 96


class Line:
    """What becomes of datagrams on their way: here they pass. The suite has worse ones."""

    def inward(self, payload: bytes) -> list[bytes]:
        return [payload]

    def outward(self, payload: bytes) -> list[bytes]:
        return [payload]


class Visitor:
    """A client's connection, as the server has it."""

    def __init__(self, first: Header, accepted: Accepted, publish: Callable[[bytes], None]) -> None:
        self.client = first.client
        self.key = accepted.client
        self.publish = publish
        self.sealed = SealedConnection(
            accepted.channel, Header(Kind.SEALED, 0, first.client), publish
        )
        self.on_frame: Callable[[Frame, float], None] = lambda frame, age: None
        self.on_gone: Callable[[], None] = lambda: None
        self.bye = False
        """Whether one of the two said so."""

    def silence(self, now: float) -> float:
        return now - self.sealed.heard_at if self.sealed.heard_at else 0.0


@dataclass(frozen=True, slots=True)
class _Answered:
    """A First, and what it was answered."""

    at: float
    second: bytes
    visitor: Visitor


class Listener:
    """Takes part in a loop. `on_visitor` is told of each client that has come."""

    def __init__(self, loop: Loop, keys: Keys, place: str = "") -> None:
        number = secrets.randbits(64)
        self.place = place or place_of(20000 + secrets.randbelow(12001), f"GO{number:016x}")
        self.keys = keys
        self.answers_ask = bool(place)
        self.line = Line()
        self.visitors: dict[int, Visitor] = {}
        self.on_visitor: Callable[[Visitor], None] = lambda visitor: None
        self.on_tick: Callable[[float], None] = lambda now: None
        self.silent_s = SILENT_S
        """After so much silence a connection is lost."""
        self.asked = 0
        port, channel = parse_place(self.place)
        self.ear = Ear(port, channel)
        self._loop = loop
        self._answered: OrderedDict[bytes, _Answered] = OrderedDict()
        loop.join(self)

    @property
    def address(self) -> str:
        return f"{self.place}#{self.keys.public.hex()}"

    def heard(self, payload: bytes) -> None:
        for come in self.line.inward(payload):
            self._heard(come)

    def _heard(self, payload: bytes) -> None:
        header = Header.of(payload)
        if header is None or header.reply_port == 0 or header.client == 0:
            return
        size = len(payload) - HEADER
        if header.kind == Kind.ASK and size == 0 and self.answers_ask:
            self.asked += 1
            self._publish(header, Header(Kind.KEY, 0, header.client).pack() + self.keys.public)
        elif header.kind == Kind.FIRST and size == FIRST_SIZE:
            self._first(header, payload)
        elif header.kind == Kind.SEALED:
            self._sealed(header, payload)

    def _publish(self, to: Header, payload: bytes) -> None:
        for goes in self.line.outward(payload):
            self._loop.mouth.publish(to.reply_port, f"GC{to.client:016x}", goes)

    def _first(self, header: Header, payload: bytes) -> None:
        now = time.monotonic()
        known = self._answered.get(payload)
        if known is None and header.client not in self.visitors:
            accepted = accept(self.keys, self.place, payload[:HEADER], payload[HEADER:])
            if accepted is None:
                return
            visitor = Visitor(header, accepted, lambda sealed: self._publish(header, sealed))
            second = Header(Kind.SECOND, 0, header.client).pack() + accepted.second
            known = self._answered[payload] = _Answered(now, second, visitor)
            if len(self._answered) > REMEMBERED:
                self._answered.popitem(last=False)
        if known is not None and now - known.at < REMEMBERED_S:
            self._publish(header, known.second)

    def _sealed(self, header: Header, payload: bytes) -> None:
        visitor = self.visitors.get(header.client)
        if visitor is not None:
            self._open(visitor, payload)
            return
        since = time.monotonic() - REMEMBERED_S
        for first in self._answered.values():
            came_before = first.visitor.sealed.heard_at is not None
            if first.visitor.client != header.client or first.at < since or came_before:
                continue
            if self._open(first.visitor, payload):
                return

    def _open(self, visitor: Visitor, payload: bytes) -> bool:
        """Whether it is this client's; the first such frame makes it one who has come."""
        opened = visitor.sealed.receive(payload)
        if visitor.sealed.heard_at is None:
            return False
        if visitor.client not in self.visitors:
            self.visitors[visitor.client] = visitor
            visitor.sealed.send(Inner.BEAT)
            self.on_visitor(visitor)
        if opened is None:
            return True
        frame, age = opened
        if frame.kind == Inner.BYE:
            visitor.bye = True
            self._gone(visitor)
        else:
            visitor.on_frame(frame, age)
        return True

    def _gone(self, visitor: Visitor) -> None:
        del self.visitors[visitor.client]
        visitor.on_gone()

    def tick(self, now: float) -> None:
        for visitor in list(self.visitors.values()):
            if visitor.silence(now) > self.silent_s:
                self._gone(visitor)
            else:
                visitor.sealed.tick(now)
        self.on_tick(now)

    def bye(self) -> None:
        """Ends all connections in order."""
        for visitor in list(self.visitors.values()):
            visitor.sealed.send(Inner.BYE)
            visitor.bye = True
            self._gone(visitor)

    def close(self) -> None:
        self.bye()
        self._loop.leave(self)
