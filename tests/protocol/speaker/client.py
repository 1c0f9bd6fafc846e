"""A client: a session with one object, and its calls."""

from __future__ import annotations

import os
import secrets
import time
from dataclasses import dataclass, field, replace

from . import packets
from .connection import Connection
from .frames import Frame, Inner
from .lcm import Again, Loop
from .noise import Keys
from .packets import Detail, Packet, Reader, Status, Welcome
from .streams import Share, StreamReader

UNREACHABLE_S = 0.5
LOST_S = 1.5
OLDEST_NS = 750_000_000


@dataclass(slots=True)
class Call:
    packet: Packet
    end: float | None
    again: Again = field(default_factory=Again)
    progress: list[Packet] = field(default_factory=list)
    replies: list[Packet] = field(default_factory=list)
    canceling: Again | None = None

    @property
    def reply(self) -> Packet:
        return self.replies[0]

    @property
    def over(self) -> bool:
        return bool(self.replies)


class Session:
    """Says Hello by itself; calls and cancels are repeated until they are answered."""

    def __init__(self, loop: Loop, address: str, keys: Keys, interface: str) -> None:
        self.loop = loop
        self.connection = Connection(loop, address, keys)
        self.connection.on_frame = self._take
        self.connection.on_tick = self.tick
        self.interface = interface
        self.id = 0
        self.epoch = 0
        self.welcome: Welcome | None = None
        self.refused: packets.Failure | None = None
        self.goodbye: Packet | None = None
        self.received: list[Packet] = []
        self.shares: dict[int, StreamReader] = {}
        self.calls: dict[int, Call] = {}
        self.acknowledges = True
        """Whether packets say which replies have come."""
        self._counter = 0
        self._again = Again()
        who = "speaker", "nowhere", "protocol-speaker", os.getpid(), secrets.randbits(64)
        self.hello = packets.Hello(*who, interface, 0, OLDEST_NS)

    @property
    def acknowledged(self) -> int:
        if not self.acknowledges:
            return 0
        open_ones = [counter for counter, call in self.calls.items() if not call.over]
        return min(open_ones) - 1 if open_ones else self._counter

    def send(self, packet: Packet) -> None:
        sealed = self.connection.sealed
        if sealed is None:
            return
        sealed.send_packet(replace(packet, session=self.id, acknowledged=self.acknowledged).pack())

    def _silence(self, now: float) -> float:
        sealed = self.connection.sealed
        return now - sealed.heard_at if sealed and sealed.heard_at else 0.0

    def tick(self, now: float) -> None:
        sealed = self.connection.sealed
        if sealed is None or self.connection.closed or self.refused or self.goodbye:
            return
        if not self.welcome:
            if self._again.due(now):
                self.send(Packet(packets.Kind.HELLO, body=self.hello.pack()))
            return
        assert self._silence(now) < LOST_S, "the session is lost: the server is silent"
        for call in self.calls.values():
            self._repeat(call, now)

    def _repeat(self, call: Call, now: float) -> None:
        if call.over:
            return
        if call.canceling and call.canceling.due(now):
            self.send(Packet(packets.Kind.CANCEL, counter=call.packet.counter))
        if not call.again.due(now):
            return
        if call.progress:
            self.send(Packet(packets.Kind.QUERY, counter=call.packet.counter))
        elif self._silence(now) < UNREACHABLE_S:
            left = max(1, int((call.end - now) * 1e9)) if call.end else 0
            self.send(replace(call.packet, deadline_ns=left))

    def _take(self, frame: Frame, age: float) -> None:
        if frame.kind == Inner.SHARE:
            self._share(frame)
        if frame.kind != Inner.PACKET:
            return
        try:
            packet = Packet.of(frame.body)
        except packets.Malformed:
            return
        if packet.version != packets.VERSION:
            return
        self.received.append(packet)
        if packet.kind == packets.Kind.WELCOME and not self.welcome:
            self.id, self.welcome = packet.session, Welcome.of(packet.body)
        elif packet.kind == packets.Kind.REFUSED:
            self.refused = packets.Failure.of(packet.body)
        elif packet.kind == packets.Kind.GOODBYE:
            self.goodbye = packet
        elif packet.session == self.id and packet.counter in self.calls:
            call = self.calls[packet.counter]
            if packet.kind == packets.Kind.REPLY:
                call.replies.append(packet)
            elif packet.kind == packets.Kind.PROGRESS:
                call.progress.append(packet)

    def _share(self, frame: Frame) -> None:
        share = Share.of(frame.body)
        sealed = self.connection.sealed
        if share is None or share.id != frame.number or sealed is None:
            return
        known = self.shares.get(share.id)
        if known is None or known.share != share:
            if known:
                self.loop.leave(known)
            self.shares[share.id] = StreamReader(share)
            self.loop.join(self.shares[share.id])
        sealed.send(Inner.OPENED, share.id)

    def ready(self) -> Welcome:
        """Waits for Welcome."""
        self.loop.until(lambda: bool(self.welcome or self.refused), f"answer to {self.interface}")
        assert self.welcome, f"refused: {self.refused}"
        return self.welcome

    def count(self) -> int:
        """The next counter: commands start in their order, so none may be left out."""
        self._counter += 1
        return self._counter

    def start(self, code: int, parameters: bytes = b"", deadline_s: float | None = None) -> Call:
        packet = Packet(
            packets.Kind.CALL, code=code, counter=self.count(), epoch=self.epoch, body=parameters
        )
        call = Call(packet, time.monotonic() + deadline_s if deadline_s else None)
        self.calls[self._counter] = call
        self.tick(time.monotonic())
        return call

    def finish(self, call: Call) -> Packet:
        self.loop.until(lambda: call.over, f"reply to {call.packet}")
        return call.reply

    def call(self, code: int, parameters: bytes = b"") -> Packet:
        return self.finish(self.start(code, parameters))

    def cancel(self, call: Call) -> None:
        call.canceling = Again()

    def acquire(self, status: Status, password: str = "") -> int:
        """Takes a status; its epoch is in every call from then on."""
        given = packets.boolean(True) + packets.string(password) if password else b""
        reply = self.call(packets.ACQUIRE, packets.u32(status) + given)
        assert reply.detail == Detail.DONE, packets.Failure.of(reply.body)
        grant = Reader(reply.body).block()
        assert grant.u32() == status
        self.epoch = grant.u64()
        return self.epoch

    def end(self) -> Packet:
        """Goodbye, until the server says it too."""
        again = Again()

        def answered() -> bool:
            if not self.goodbye and again.due(time.monotonic()):
                self.send(Packet(packets.Kind.GOODBYE))
            return self.goodbye is not None

        self.loop.until(answered, "the server's Goodbye")
        assert self.goodbye is not None
        return self.goodbye

    def close(self) -> None:
        for reader in self.shares.values():
            self.loop.leave(reader)
        self.connection.close()
