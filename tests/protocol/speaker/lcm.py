"""LCM's datagrams over UDP multicast, and the loop that waits for them."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Callable, Iterator
from typing import Protocol

GROUP = "239.255.76.67"
BROKER_PLACE = f"lcm:{GROUP}:7668/GWBROKER"
TICK_S = 0.004
PATIENCE_S = 30.0


def place_of(port: int, channel: str) -> str:
    return f"lcm:{GROUP}:{port}/{channel}"


def parse_place(place: str) -> tuple[int, str]:
    """Port and LCM channel of `lcm:<group>:<port>/<channel>`."""
    group, port, channel = place.removeprefix("lcm:").replace("/", ":").split(":")
    assert group == GROUP, f"this speaker only knows {GROUP}: {place}"
    return int(port), channel


def datagram(number: int, channel: str, payload: bytes) -> bytes:
    return b"LC02" + struct.pack(">I", number) + channel.encode() + b"\0" + payload


class Mouth:
    """Publishes, to this host only."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        self._number = 0

    def publish(self, port: int, channel: str, payload: bytes) -> None:
        self._number += 1
        self._socket.sendto(datagram(self._number, channel, payload), (GROUP, port))

    def close(self) -> None:
        self._socket.close()


class Ear:
    """Hears one channel at one port."""

    def __init__(self, port: int, channel: str) -> None:
        self._channel = channel.encode()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind((GROUP, port))
        anywhere = socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0")  # the route's interface
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, anywhere)
        self._socket.setblocking(False)

    def fileno(self) -> int:
        return self._socket.fileno()

    def waiting(self) -> Iterator[bytes]:
        """What was published on the channel and not been read yet, without LCM's head."""
        while True:
            try:
                raw = self._socket.recv(65536)
            except BlockingIOError:
                return
            channel, zero, payload = raw[8:].partition(b"\0")
            if raw[:4] == b"LC02" and zero and channel == self._channel:
                yield payload

    def close(self) -> None:
        self._socket.close()


class Party(Protocol):
    """Takes part in a loop."""

    @property
    def ear(self) -> Ear: ...
    def heard(self, payload: bytes) -> None: ...
    def tick(self, now: float) -> None: ...


class Again:
    """When to send once more: 20, 40, 80, 160, 160, … ms after the time before."""

    def __init__(self) -> None:
        self.at = 0.0  # at once
        self._pause = 0.02

    def due(self, now: float) -> bool:
        if now < self.at:
            return False
        self.at = now + self._pause
        self._pause = min(2 * self._pause, 0.16)
        return True


class Loop:
    """Everything that takes part, in one thread; sends by one socket."""

    def __init__(self) -> None:
        self.mouth = Mouth()
        self.parties: list[Party] = []

    def join(self, party: Party) -> None:
        self.parties.append(party)

    def leave(self, party: Party) -> None:
        self.parties.remove(party)
        party.ear.close()

    def turn(self) -> None:
        """Waits a moment for datagrams, hands them out, and lets everybody see the time."""
        parties = list(self.parties)
        select.select([party.ear for party in parties], [], [], TICK_S)
        now = time.monotonic()  # before all is read: nobody is silent who was only not read
        for party in parties:
            if party not in self.parties:
                continue
            for payload in party.ear.waiting():
                party.heard(payload)
            if party in self.parties:
                party.tick(now)

    def until(self, happened: Callable[[], bool], what: str, patience: float = PATIENCE_S) -> None:
        end = time.monotonic() + patience
        while not happened():
            assert time.monotonic() < end, f"not within {patience} s: {what}"
            self.turn()

    def for_seconds(self, seconds: float) -> None:
        """For what must not happen."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.turn()

    def close(self) -> None:
        for party in list(self.parties):
            self.leave(party)
        self.mouth.close()
