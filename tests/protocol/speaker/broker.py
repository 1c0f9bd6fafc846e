"""The broker's interface: who is where."""

from __future__ import annotations

from dataclasses import dataclass

from .client import Session
from .packets import (
    Detail,
    Failure,
    Reader,
    block,
    boolean,
    code_of,
    f64,
    sequence,
    string,
    u32,
    u64,
)

ENLIST = code_of("gecos::Broker::enlist")
LOOKUP = code_of("gecos::Broker::lookup")


@dataclass(frozen=True, slots=True)
class Entry:
    name: str
    interface: str
    bases: list[str]
    hash: int
    boot: int
    pid: int
    user: str
    host: str
    hostname: str
    addresses: list[str]
    simulated: bool

    def pack(self) -> bytes:
        what = string(self.name) + string(self.interface) + sequence(map(string, self.bases))
        what += u64(self.hash) + u64(self.boot) + u32(self.pid)
        what += string(self.user) + string(self.host) + string(self.hostname)
        return block(what + sequence(map(string, self.addresses)) + boolean(self.simulated))

    @staticmethod
    def of(value: Reader) -> Entry:
        r = value.block()
        what = r.string(), r.string(), r.sequence(r.string), r.u64(), r.u64(), r.u32()
        who = r.string(), r.string(), r.string()
        return Entry(*what, *who, r.sequence(r.string), r.boolean())

    @property
    def lcm_address(self) -> str:
        return next(address for address in self.addresses if address.startswith("lcm:"))


def lookup(broker: Session, name: str) -> Entry:
    reply = broker.call(LOOKUP, string(name))
    assert reply.detail == Detail.DONE, Failure.of(reply.body)
    return Entry.of(Reader(reply.body))


def enlist(broker: Session, entry: Entry, served_for: float = 0.0) -> float | None:
    """In how many seconds the name is settled; None: it is."""
    reply = broker.call(ENLIST, entry.pack() + f64(served_for))
    assert reply.detail == Detail.DONE, Failure.of(reply.body)
    return settles_in(Reader(reply.body))


def settles_in(reply: Reader) -> float | None:
    return reply.f64() if reply.boolean() else None
