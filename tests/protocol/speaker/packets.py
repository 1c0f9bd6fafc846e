"""Values as they stand in packets, and the packets (docs/protocol.md, Values to Calls)."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeVar

T = TypeVar("T")

FINGERPRINT = 0x90A18DA222518B52
VERSION = 1
_HEAD = struct.Struct(">QBBBBIQQQQqi")


class Kind(IntEnum):
    HELLO = 1
    WELCOME = 2
    REFUSED = 3
    CALL = 4
    REPLY = 5
    PROGRESS = 6
    CANCEL = 7
    GOODBYE = 11
    QUERY = 12


class Detail(IntEnum):
    QUEUED = 1
    EXECUTING = 2
    CANCELING = 3
    DONE = 5
    REJECTED = 6
    BAD_PARAMETER = 7
    UNKNOWN_OPERATION = 8
    DENIED = 9
    QUEUE_FULL = 10
    EXPIRED = 11
    TIMED_OUT = 12
    FAULT = 13
    CANCELED = 14
    PREEMPTED = 15
    STOPPED = 16
    LEASE_LOST = 17
    PRESENCE_LOST = 18
    OUTCOME_UNKNOWN = 20
    NOT_STARTED = 21
    REFUSED = 23


class Status(IntEnum):
    SENSOR = 0
    ACTOR = 1
    MASTER = 2


HOLDERS, STOP, PING, DESCRIBE, ACQUIRE, RELEASE, SUBSCRIBE, UNSUBSCRIBE, OUTCOME = range(1, 10)
TAKE_OVER, GIVE_BACK = 14, 15


class Malformed(ValueError):
    """The bytes are not what the protocol says."""


def code_of(scoped_name: str) -> int:
    """FNV-1a of 32 bits."""
    code = 2166136261
    for character in scoped_name.encode():
        code = (code ^ character) * 16777619 % 2**32
    return code


def u32(value: int) -> bytes:
    return struct.pack(">I", value)


def u64(value: int) -> bytes:
    return struct.pack(">Q", value)


def f64(value: float) -> bytes:
    return struct.pack(">d", value)


def boolean(value: bool) -> bytes:
    return bytes([value])


def string(text: str) -> bytes:
    raw = text.encode() + b"\0"
    return u32(len(raw)) + raw


def sequence(elements: Iterable[bytes]) -> bytes:
    parts = list(elements)
    return u32(len(parts)) + b"".join(parts)


def block(members: bytes) -> bytes:
    """An `@appendable` struct."""
    return u32(len(members)) + members


class Reader:
    """Takes values off the front of bytes."""

    def __init__(self, raw: bytes) -> None:
        self._raw = raw
        self._at = 0

    def take(self, size: int) -> bytes:
        if size < 0 or self._at + size > len(self._raw):
            raise Malformed(f"{size} bytes wanted at {self._at} of {len(self._raw)}")
        self._at += size
        return self._raw[self._at - size : self._at]

    def rest(self) -> bytes:
        return self.take(len(self._raw) - self._at)

    def end(self) -> None:
        if self._at != len(self._raw):
            raise Malformed(f"{len(self._raw) - self._at} bytes are left over")

    def i32(self) -> int:
        return int.from_bytes(self.take(4), "big", signed=True)

    def u32(self) -> int:
        return int.from_bytes(self.take(4), "big")

    def u64(self) -> int:
        return int.from_bytes(self.take(8), "big")

    def i64(self) -> int:
        return int.from_bytes(self.take(8), "big", signed=True)

    def f64(self) -> float:
        (value,) = struct.unpack(">d", self.take(8))
        return float(value)

    def boolean(self) -> bool:
        value = self.take(1)[0]
        if value > 1:
            raise Malformed(f"a boolean of {value}")
        return value == 1

    def string(self) -> str:
        raw = self.take(self.i32())
        if not raw.endswith(b"\0") or b"\0" in raw[:-1]:
            raise Malformed("a string without its NUL at the end, or with one before")
        return raw[:-1].decode()

    def sequence(self, element: Callable[[], T]) -> list[T]:
        return [element() for _ in range(self.i32())]

    def block(self) -> Reader:
        return Reader(self.take(self.i32()))


@dataclass(frozen=True, slots=True)
class Packet:
    kind: int
    detail: int = 0
    code: int = 0
    session: int = 0
    counter: int = 0
    acknowledged: int = 0
    epoch: int = 0
    deadline_ns: int = 0
    body: bytes = b""
    version: int = VERSION

    def pack(self) -> bytes:
        numbers = self.session, self.counter, self.acknowledged, self.epoch, self.deadline_ns
        head = _HEAD.pack(
            FINGERPRINT,
            self.version,
            self.kind,
            self.detail,
            0,
            self.code,
            *numbers,
            len(self.body),
        )
        return head + self.body + u32(0)

    @staticmethod
    def of(raw: bytes) -> Packet:
        """Reads a packet of any version; a server answers only a Hello of another version."""
        reader = Reader(raw)
        head = _HEAD.unpack(reader.take(_HEAD.size))
        fingerprint, version, kind, detail, _, code = head[:6]
        session, counter, acknowledged, epoch, deadline_ns, size = head[6:]
        body, tag = reader.take(size), reader.u32()
        reader.end()
        if fingerprint != FINGERPRINT or tag != 0 or deadline_ns < 0:
            raise Malformed(f"no packet: {raw[:60].hex()}")
        numbers = session, counter, acknowledged, epoch, deadline_ns
        return Packet(kind, detail, code, *numbers, body, version)


@dataclass(frozen=True, slots=True)
class Hello:
    user: str
    host: str
    program: str
    pid: int
    boot: int
    interface: str
    hash: int
    oldest_ns: int

    def pack(self) -> bytes:
        who = string(self.user) + string(self.host) + string(self.program)
        who += u32(self.pid) + u64(self.boot)
        return who + string(self.interface) + u64(self.hash) + u64(self.oldest_ns)

    @staticmethod
    def of(body: bytes) -> Hello:
        r = Reader(body)
        who = r.string(), r.string(), r.string(), r.u32(), r.u64()
        hello = Hello(*who, r.string(), r.u64(), r.i64())
        r.end()
        return hello


@dataclass(frozen=True, slots=True)
class Welcome:
    name: str
    interface: str
    bases: list[str]
    hash: int
    boot: int
    credits: int
    operations: dict[int, int]
    """Code and hash."""

    def pack(self) -> bytes:
        what = string(self.name) + string(self.interface) + sequence(map(string, self.bases))
        what += u64(self.hash) + u64(self.boot) + u32(self.credits)
        return what + sequence(u32(code) + u64(hash) for code, hash in self.operations.items())

    @staticmethod
    def of(body: bytes) -> Welcome:
        r = Reader(body)
        what = r.string(), r.string(), r.sequence(r.string), r.u64(), r.u64(), r.u32()
        welcome = Welcome(*what, dict(r.sequence(lambda: (r.u32(), r.u64()))))
        r.end()
        return welcome


@dataclass(frozen=True, slots=True)
class Failure:
    text: str
    exception: str = ""
    value: bytes = b""

    def pack(self) -> bytes:
        return string(self.text) + string(self.exception) + self.value

    @staticmethod
    def of(body: bytes) -> Failure:
        r = Reader(body)
        return Failure(r.string(), r.string(), r.rest())


@dataclass(frozen=True, slots=True)
class Progress:
    before: int
    fraction: float
    feedback: bytes = b""

    def pack(self) -> bytes:
        return u32(self.before) + f64(self.fraction) + self.feedback

    @staticmethod
    def of(body: bytes) -> Progress:
        r = Reader(body)
        return Progress(r.u32(), r.f64(), r.rest())
