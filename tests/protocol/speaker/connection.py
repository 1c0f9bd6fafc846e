"""A client's connection to one server: the handshake, then frames."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable

from .frames import HEADER, Frame, Header, Inner, Kind, SealedConnection
from .lcm import Again, Ear, Loop, parse_place
from .noise import Initiation, Keys

HANDSHAKE_S = 5.0


class Connection:
    """Makes the channel, then carries frames; takes part in a loop."""

    def __init__(self, loop: Loop, address: str, keys: Keys) -> None:
        self.place, _, key = address.partition("#")
        self.port, self.channel = parse_place(self.place)
        self.keys = keys
        self.client = secrets.randbelow(2**64 - 1) + 1
        self.reply_port = 20000 + secrets.randbelow(12001)
        self.ear = Ear(self.reply_port, f"GC{self.client:016x}")
        self.sealed: SealedConnection | None = None
        self.on_frame: Callable[[Frame, float], None] = lambda frame, age: None
        self.on_tick: Callable[[float], None] = lambda now: None
        self.closed = False
        self._loop = loop
        self._fixed = bytes.fromhex(key)
        self.server = self._fixed
        self._initiation: Initiation | None = None
        self._again, self._began = Again(), time.monotonic()
        loop.join(self)

    def header(self, kind: Kind) -> Header:
        return Header(kind, self.reply_port, self.client)

    def publish(self, payload: bytes) -> None:
        self._loop.mouth.publish(self.port, self.channel, payload)

    def heard(self, payload: bytes) -> None:
        header = Header.of(payload)
        if header is None or header.client != self.client or header.reply_port != 0:
            return
        rest = payload[HEADER:]
        if header.kind == Kind.KEY and len(rest) == 32 and not self.server:
            if self.keys.admits(rest):
                self.server, self._again = rest, Again()
        elif header.kind == Kind.SECOND and self._initiation and self.sealed is None:
            channel = self._initiation.finish(rest)
            if channel:
                self._again = Again()
                self.sealed = SealedConnection(channel, self.header(Kind.SEALED), self.publish)
        elif header.kind == Kind.SEALED and self.sealed:
            opened = self.sealed.receive(payload)
            if opened:
                self._take(*opened)

    def _take(self, frame: Frame, age: float) -> None:
        if frame.kind == Inner.BYE:
            self.closed = True
        else:
            self.on_frame(frame, age)

    def tick(self, now: float) -> None:
        if self.closed:
            return
        if self.sealed is None:
            self._shake_hands(now)
        elif self.sealed.heard_at is None:  # the server does not know yet that we are here
            if self._again.due(now):
                self.sealed.send(Inner.BEAT)
        else:
            self.sealed.tick(now)
        self.on_tick(now)

    def _shake_hands(self, now: float) -> None:
        if now - self._began > HANDSHAKE_S:
            self.server, self._initiation = self._fixed, None
            self._again, self._began = Again(), now
        if not self._again.due(now):
            return
        if not self.server:
            self.publish(self.header(Kind.ASK).pack())
            return
        header = self.header(Kind.FIRST).pack()
        if self._initiation is None:
            self._initiation = Initiation(self.keys.secret, self.server, self.place, header)
        self.publish(header + self._initiation.first)

    def close(self) -> None:
        """Ends it in order."""
        if self.sealed and not self.closed:
            self.sealed.send(Inner.BYE)
        self._loop.leave(self)
