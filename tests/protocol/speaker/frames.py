"""Datagrams behind LCM's head, the sealed frames in them, and large packets in pieces."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from .noise import Channel

SMALL = 8192
LARGEST = 8 << 20
AHEAD = 8
BEAT_S = 0.1
RESEND_S = 0.02

_HEADER = struct.Struct(">HBBHHQ")
_INNER = struct.Struct(">BQQ")
_PIECE = struct.Struct(">QQII")
_PIECE_MARK = 0x6765636F73207031
_RECEIVED_MARK = 0x6765636F73206131


class Kind(IntEnum):
    ASK = 1
    KEY = 2
    FIRST = 3
    SECOND = 4
    SEALED = 5
    SAMPLE = 6


class Inner(IntEnum):
    PACKET = 1
    BEAT = 2
    BYE = 3
    SHARE = 4
    OPENED = 5
    UNSHARE = 6


@dataclass(frozen=True, slots=True)
class Header:
    kind: int
    reply_port: int
    client: int

    def pack(self) -> bytes:
        return _HEADER.pack(0x6763, 2, self.kind, self.reply_port, 0, self.client)

    @staticmethod
    def of(payload: bytes) -> Header | None:
        """The header of a datagram that a receiver may look at."""
        if len(payload) < _HEADER.size:
            return None
        magic, version, kind, port, _, client = _HEADER.unpack_from(payload)
        known = magic == 0x6763 and version == 2 and kind in list(Kind)
        return Header(kind, port, client) if known else None


HEADER = _HEADER.size


@dataclass(frozen=True, slots=True)
class Frame:
    kind: int
    number: int
    sent_ns: int
    body: bytes

    def pack(self) -> bytes:
        return _INNER.pack(self.kind, self.number, self.sent_ns) + self.body

    @staticmethod
    def of(text: bytes) -> Frame | None:
        if len(text) < _INNER.size:
            return None
        kind, number, sent_ns = _INNER.unpack_from(text)
        return Frame(kind, number, sent_ns, text[_INNER.size :])


class Age:
    """How long a frame waited on its way, by the least difference of clocks so far."""

    def __init__(self) -> None:
        self._least: float | None = None
        self._measured = 0

    def of(self, sent_ns: int, now_ns: int) -> float:
        difference = now_ns - sent_ns
        if self._least is not None:
            self._least += (now_ns - self._measured) / 2000
        if self._least is None or difference < self._least:
            self._least = difference
        self._measured = now_ns
        return difference - self._least


class PiecesOut:
    """The large packets that one side sends, one after the other."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self._send = send
        self._waiting: list[bytes] = []
        self._packet = b""
        self._transfer = 0
        self._missing: dict[int, int] = {}  # index: its last sending, 0 for none
        self._sendings = 0
        self._heard = 0.0

    def put(self, packet: bytes) -> None:
        assert len(packet) <= LARGEST
        self._waiting.append(packet)
        if not self._missing:
            self._next()

    def _next(self) -> None:
        if self._waiting:
            self._packet = self._waiting.pop(0)
            self._transfer += 1
            self._missing = dict.fromkeys(range((len(self._packet) + SMALL - 1) // SMALL), 0)
            self._heard = time.monotonic()
            self._fill()

    def _put_piece(self, index: int) -> None:
        self._sendings += 1
        self._missing[index] = self._sendings
        head = _PIECE.pack(_PIECE_MARK, self._transfer, len(self._packet), index)
        self._send(head + self._packet[index * SMALL : (index + 1) * SMALL])

    def _fill(self, lost: Callable[[int], bool] = lambda sending: False) -> None:
        first = min(self._missing)
        for index, sending in list(self._missing.items()):
            if index <= first + AHEAD - 1 and (sending == 0 or lost(sending)):
                self._put_piece(index)

    def received(self, body: bytes) -> None:
        _, transfer, whole, bits = _PIECE.unpack(body)
        if transfer != self._transfer or not self._missing:
            return
        self._heard = time.monotonic()
        marked = bits << (whole + 1)  # bit i: piece i is there
        there = [i for i in self._missing if i < whole or marked >> i & 1]
        newest = max((self._missing.pop(i) for i in there), default=0)
        if self._missing:
            self._fill(lambda sending: sending + 3 <= newest)
        else:
            self._next()

    def tick(self, now: float) -> None:
        if self._missing and now - self._heard >= RESEND_S:
            self._heard = now
            self._fill(lambda sending: True)


class PiecesIn:
    """The large packets that one side receives."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self._send = send
        self._transfer = 0
        self._size = 0
        self._pieces: dict[int, bytes] = {}

    def take(self, body: bytes) -> bytes | None:
        """The packet, when this was its last piece."""
        _, transfer, size, index = _PIECE.unpack_from(body)
        piece = body[_PIECE.size :]
        count = (size + SMALL - 1) // SMALL
        last = size - (count - 1) * SMALL
        if not 0 < size <= LARGEST or index >= count:
            return None
        if len(piece) != (last if index == count - 1 else SMALL):
            return None
        if transfer < self._transfer:
            self._answer(transfer, count, 0)
            return None
        if transfer > self._transfer:
            self._transfer, self._size, self._pieces = transfer, size, {}
        if size != self._size:
            return None
        new = index not in self._pieces
        self._pieces.setdefault(index, piece)
        whole = next(i for i in range(count + 1) if i not in self._pieces)
        bits = sum(1 << i for i in range(32) if whole + 1 + i in self._pieces)
        self._answer(transfer, whole, bits)
        return b"".join(self._pieces[i] for i in range(count)) if new and whole == count else None

    def _answer(self, transfer: int, whole: int, bits: int) -> None:
        self._send(_PIECE.pack(_RECEIVED_MARK, transfer, whole, bits))


class SealedConnection:
    """One side of an open connection: seals what goes out, opens what comes in."""

    def __init__(self, channel: Channel, header: Header, publish: Callable[[bytes], None]) -> None:
        self.channel = channel
        self.header = header
        self._header = header.pack()
        self._publish = publish
        self._numbers = 0
        self._age = Age()
        self._out = PiecesOut(lambda body: self._put(body))
        self._in = PiecesIn(lambda body: self._put(body))
        self._beat = 0.0
        self.heard_at: float | None = None

    def seal(self, kind: int, number: int, body: bytes, sent_ns: int | None = None) -> bytes:
        """The datagram of a frame."""
        at = time.monotonic_ns() if sent_ns is None else sent_ns
        text = Frame(kind, number, at, body).pack()
        return self._header + self.channel.sealer.seal(self._header, text)

    def send(self, kind: int, number: int = 0, body: bytes = b"") -> None:
        self._publish(self.seal(kind, number, body))

    def _put(self, body: bytes) -> None:
        self._numbers += 1
        self.send(Inner.PACKET, self._numbers, body)

    def send_packet(self, packet: bytes) -> None:
        if len(packet) <= SMALL:
            self._put(packet)
        else:
            self._out.put(packet)

    def receive(self, payload: bytes) -> tuple[Frame, float] | None:
        """The frame in a datagram and its age in ns; pieces are put together on the way."""
        text = self.channel.opener.open(payload[:HEADER], payload[HEADER:])
        frame = Frame.of(text) if text is not None else None
        if frame is None:
            return None
        self.heard_at = time.monotonic()
        age = self._age.of(frame.sent_ns, time.monotonic_ns())
        if frame.kind != Inner.PACKET or len(frame.body) < _PIECE.size:
            return frame, age
        mark = int.from_bytes(frame.body[:8], "big")
        if mark == _RECEIVED_MARK and len(frame.body) == _PIECE.size:
            self._out.received(frame.body)
            return None
        if mark == _PIECE_MARK:
            whole = self._in.take(frame.body)
            return (Frame(frame.kind, frame.number, frame.sent_ns, whole), age) if whole else None
        return frame, age

    def tick(self, now: float) -> None:
        self._out.tick(now)
        if now - self._beat >= BEAT_S:
            self._beat = now
            self.send(Inner.BEAT)
