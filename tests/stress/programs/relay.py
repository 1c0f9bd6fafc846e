"""Stands between two hosts as an attacker of the network: relays each frame, twice, keeps it, and
plays the kept frames back to the hosts on command.

Reads commands from its input: `keep FILE` writes what it has heard so far as a pcap file, `play
ORDER` plays that back. Nothing reaches a host but through `Relay.send`.
"""

from __future__ import annotations

import contextlib
import random
import select
import socket
import struct
import sys
from pathlib import Path

ALL_PROTOCOLS = 0x0003
RCVBUFFORCE = 33  # of Linux; Python has no name for it
LARGEST_FRAME = 1 << 16
IPV4, UDP = 0x0800, 17
LINK_ETHERNET = 1


def begins_datagram(frame: bytes) -> bool:
    """Whether the header of UDP is in it: a later fragment of a datagram has none."""
    if len(frame) < 42 or struct.unpack_from("!H", frame, 12)[0] != IPV4 or frame[23] != UDP:
        return False
    return bool(struct.unpack_from("!H", frame, 20)[0] & 0x1FFF == 0)


def without_checksum(frame: bytes) -> bytes:
    """The kernel leaves the checksum of UDP to the network card, and there is none. 0 means that
    the sender made no checksum."""
    if not begins_datagram(frame):
        return frame
    at = 14 + 4 * (frame[14] & 0xF) + 6
    return frame[:at] + b"\0\0" + frame[at + 2 :]


class Relay:
    def __init__(self) -> None:
        self._ends = [self._open(f"end{end}") for end in range(2)]
        self._kept: list[tuple[int, bytes]] = []

    @staticmethod
    def _open(interface: str) -> socket.socket:
        end = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ALL_PROTOCOLS))
        with contextlib.suppress(PermissionError):  # root of a namespace may not
            end.setsockopt(socket.SOL_SOCKET, RCVBUFFORCE, 1 << 24)
        end.bind((interface, ALL_PROTOCOLS))
        return end

    def send(self, end: int, frame: bytes) -> None:
        self._ends[end].send(frame)

    def relay(self, patience: float) -> bool:
        """Relays what comes within `patience` s. Returns whether a command waits."""
        ready, _, _ = select.select([*self._ends, sys.stdin], [], [], patience)
        for end, other in ((0, 1), (1, 0)):
            if self._ends[end] not in ready:
                continue
            frame, (_, _, kind, *_) = self._ends[end].recvfrom(LARGEST_FRAME)
            if kind == socket.PACKET_OUTGOING:
                continue
            frame = without_checksum(frame)
            self._kept.append((other, frame))
            for _ in range(2):
                self.send(other, frame)
        return sys.stdin in ready

    def keep(self, file: Path) -> int:
        with file.open("wb") as pcap:
            pcap.write(struct.pack("=IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 1 << 16, LINK_ETHERNET))
            for number, (_, frame) in enumerate(self._kept):
                pcap.write(struct.pack("=IIII", number, 0, len(frame), len(frame)) + frame)
        return len(self._kept)

    def play(self, order: str) -> int:
        """Returns how many datagrams it played to the first host."""
        frames = list(self._kept)
        if order == "shuffled":
            random.Random(16).shuffle(frames)
        elif order == "doubled":
            frames = [frame for frame in frames for _ in range(2)]
        for end, frame in frames:
            self.send(end, frame)
            self.relay(0.0005)  # the buffers of the hosts must not overflow
        return sum(end == 0 and begins_datagram(frame) for end, frame in frames)


def main() -> None:
    relay = Relay()
    print("relays", flush=True)
    while True:
        if not relay.relay(1.0):
            continue
        words = sys.stdin.readline().split()
        if not words:
            return
        if words[0] == "keep":
            print("kept", relay.keep(Path(words[1])), flush=True)
        else:
            print("played", relay.play(words[1]), words[1], flush=True)


if __name__ == "__main__":
    main()
