"""A client over lcm that was written from docs/protocol.md, and shares no line with ours.

Python's own library, and PyPI's noiseprotocol with the `cryptography` it rests on.
"""

from __future__ import annotations

import os
import re
import socket
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cryptography.exceptions import InvalidTag
from noise.connection import Keypair, NoiseConnection

HEADER = struct.Struct(">HBBHHQ")
MAGIC, VERSION = 0x6763, 2
ASK, KEY, FIRST, SECOND, SEALED = 1, 2, 3, 4, 5

INNER = struct.Struct(">BQq")
PACKET, BEAT, BYE = 1, 2, 3

ENVELOPE = struct.Struct(">QbbbbIQQQQqI")
FINGERPRINT = 0x90A18DA222518B52
HELLO, WELCOME, REFUSED, CALL, REPLY, PROGRESS, CANCEL, GOODBYE, QUERY = 1, 2, 3, 4, 5, 6, 7, 11, 12
DONE, FAULT = 5, 13

PIECE = struct.Struct(">QQII")
PIECE_MARK, RECEIVED_MARK, PIECE_SIZE = 0x6765636F73207031, 0x6765636F73206131, 8192

PATIENCE_S = 20.0


def text(value: str) -> bytes:
    encoded = value.encode()
    return struct.pack(">i", len(encoded) + 1) + encoded + b"\0"


def take_text(body: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from(">i", body, at)
    return body[at + 4 : at + 3 + length].decode(), at + 4 + length


def read_key(file: Path, word: str) -> bytes:
    found = re.fullmatch(rf"{word} ([0-9a-f]{{64}}) [0-9a-f]{{8}}\n", file.read_text())
    assert found, file
    return bytes.fromhex(found[1])


@dataclass(slots=True)
class Packet:
    kind: int
    flags: int
    session: int
    counter: int
    epoch: int
    body: bytes

    @classmethod
    def read(cls, packet: bytes) -> Packet:
        fields = ENVELOPE.unpack_from(packet)
        fingerprint, version, kind, flags, _, _, session, counter, _, epoch, _, size = fields
        assert (fingerprint, version) == (FINGERPRINT, 1)
        assert len(packet) == ENVELOPE.size + size + 4
        return cls(kind, flags, session, counter, epoch, packet[ENVELOPE.size : -4])


class Channel:
    """Sections "Datagrams", "Channel" and "Large packets"."""

    def __init__(self, address: str, keys: Path) -> None:
        found = re.fullmatch(r"lcm:([0-9.]+):(\d+)/(\w+)#([0-9a-f]{64})", address)
        assert found, address
        self._group, self._port, self._channel = found[1], int(found[2]), found[3]
        self._place = address.partition("#")[0]
        self._client = int.from_bytes(os.urandom(8), "big") | 1
        self._reply_port = 20000 + os.urandom(1)[0]
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self._socket.bind((self._group, self._reply_port))
        membership = socket.inet_aton(self._group) + socket.inet_aton("0.0.0.0")
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self._noise = NoiseConnection.from_name(b"Noise_IK_25519_ChaChaPoly_SHA256")
        self._noise.set_as_initiator()
        own = read_key(keys / "own.secret", "gecos-secret-1")
        self._noise.set_keypair_from_private_bytes(Keypair.STATIC, own)
        server = bytes.fromhex(found[4])
        self._noise.set_keypair_from_public_bytes(Keypair.REMOTE_STATIC, server)
        self._counter = self._packets = self._transfers = 0
        self._pieces: dict[tuple[int, int], bytes] = {}
        self._seen: set[int] = set()
        self.loss = 0  # of every so many frames that arrive one is dropped here; 0: none
        self._arrived = 0
        self._open()

    def close(self) -> None:
        self.seal(BYE, 0)
        self._socket.close()

    def _header(self, kind: int) -> bytes:
        return HEADER.pack(MAGIC, VERSION, kind, self._reply_port, 0, self._client)

    def _publish(self, datagram: bytes) -> None:
        message = b"LC02" + bytes(4) + self._channel.encode() + b"\0" + datagram
        self._socket.sendto(message, (self._group, self._port))

    def _hear(self, patience: float) -> tuple[int, bytes, bytes] | None:
        """Kind, header and the rest of the next datagram of the server."""
        ours = f"GC{self._client:016x}".encode()
        end = time.monotonic() + patience
        while (left := end - time.monotonic()) > 0:
            self._socket.settimeout(left)
            try:
                message = self._socket.recv(65536)
            except TimeoutError:
                return None
            channel, _, datagram = message[8:].partition(b"\0")
            if message[:4] != b"LC02" or channel != ours or len(datagram) < HEADER.size:
                continue
            magic, version, kind, port, _, client = HEADER.unpack_from(datagram)
            if (magic, version, port, client) == (MAGIC, VERSION, 0, self._client):
                return kind, datagram[: HEADER.size], datagram[HEADER.size :]
        return None

    def _open(self) -> None:
        header = self._header(FIRST)
        self._noise.set_prologue(b"gecos lcm 2" + self._place.encode() + header)
        self._noise.start_handshake()
        first = header + self._noise.write_message()
        pauses = [0.02, 0.04, 0.08] + [0.16] * 25
        for pause in pauses:
            self._publish(first)
            heard = self._hear(pause)
            if heard and heard[0] == SECOND:
                self._noise.read_message(heard[2])
                break
        assert self._noise.handshake_finished, "nobody answered First"
        for pause in pauses:
            self.seal(BEAT, 0)
            if self._opened(pause):
                return
        raise AssertionError("the server has let us in and was not heard since")

    def seal(self, kind: int, number: int, body: bytes = b"") -> None:
        header = self._header(SEALED)
        state = self._noise.noise_protocol.cipher_state_encrypt
        state.set_nonce(self._counter)
        inner = INNER.pack(kind, number, time.monotonic_ns()) + body
        sealed = bytes(state.encrypt_with_ad(header, inner))
        self._publish(header + struct.pack(">Q", self._counter) + sealed)
        self._counter += 1

    def _opened(self, patience: float) -> tuple[int, bytes] | None:
        """Inner kind and body of the next frame."""
        heard = self._hear(patience)
        if heard is None or heard[0] != SEALED:
            return None
        _, header, frame = heard
        (counter,) = struct.unpack_from(">Q", frame)
        state = self._noise.noise_protocol.cipher_state_decrypt
        state.set_nonce(counter)
        try:
            inner = bytes(state.decrypt_with_ad(header, frame[8:]))
        except InvalidTag:
            return None
        assert counter not in self._seen, "a server uses no counter twice"
        self._seen.add(counter)
        return inner[0], inner[INNER.size :]

    def send(self, packet: bytes) -> None:
        """Beside a packet goes a beat: whoever is silent loses what it holds."""
        self.seal(BEAT, 0)
        self._packets += 1
        if len(packet) <= PIECE_SIZE:
            self.seal(PACKET, self._packets, packet)
            return
        self._transfers += 1
        count = -(-len(packet) // PIECE_SIZE)
        have, end = 0, time.monotonic() + PATIENCE_S
        while have < count:
            assert time.monotonic() < end, "the server takes no pieces"
            for index in range(have, min(count, have + 8)):
                head = PIECE.pack(PIECE_MARK, self._transfers, len(packet), index)
                content = packet[index * PIECE_SIZE : (index + 1) * PIECE_SIZE]
                self.seal(PACKET, self._packets, head + content)
            while (opened := self._opened(0.02)) and have < count:
                if opened[1][:8] == struct.pack(">Q", RECEIVED_MARK):
                    _, transfer, before, _ = PIECE.unpack(opened[1])
                    have = max(have, before) if transfer == self._transfers else have

    def receive(self, patience: float) -> bytes | None:
        end = time.monotonic() + patience
        while (left := end - time.monotonic()) > 0:
            opened = self._opened(left)
            if opened is None or opened[0] != PACKET:
                continue
            self._arrived += 1
            if self.loss and self._arrived % self.loss == 0:
                continue
            packet = opened[1]
            if packet[:8] == struct.pack(">Q", RECEIVED_MARK):
                continue
            if packet[:8] != struct.pack(">Q", PIECE_MARK):
                return packet
            if (whole := self._take_piece(packet)) is not None:
                return whole
        return None

    def _take_piece(self, packet: bytes) -> bytes | None:
        _, transfer, size, index = PIECE.unpack_from(packet)
        count = -(-size // PIECE_SIZE)
        fresh = (transfer, index) not in self._pieces
        self._pieces[transfer, index] = packet[PIECE.size :]
        before = next((i for i in range(count) if (transfer, i) not in self._pieces), count)
        beyond = sum(1 << i for i in range(32) if (transfer, before + 1 + i) in self._pieces)
        self.seal(PACKET, 0, PIECE.pack(RECEIVED_MARK, transfer, before, beyond))
        if before < count or not fresh:
            return None
        return b"".join(self._pieces[transfer, i] for i in range(count))


class Session:
    """Sections "Opening a session" and "Calls"."""

    def __init__(self, channel: Channel, interface: str) -> None:
        self._channel = channel
        self._session = self._counter = 0
        self.epoch = 0
        hello = text("eva") + text("lab") + text("speaker") + struct.pack(">iQ", os.getpid(), 7)
        hello += text(interface) + struct.pack(">Qq", 0, 750_000_000)
        packet = self._packet(HELLO, hello)
        self.opened = self._repeat(
            lambda: packet, lambda got: got.kind in (WELCOME, REFUSED), "no answer to Hello"
        )
        self._session = self.opened.session

    def _packet(self, kind: int, body: bytes = b"", code: int = 0, counter: int = 0) -> bytes:
        head = ENVELOPE.pack(
            *(FINGERPRINT, 1, kind, 0, 0, code, self._session, counter),
            *(max(0, self._counter - 1), self.epoch, 0, len(body)),
        )
        return head + body + bytes(4)

    def _repeat(
        self, say: Callable[[], bytes], wanted: Callable[[Packet], bool], otherwise: str
    ) -> Packet:
        end = time.monotonic() + PATIENCE_S
        pause = 0.02
        while time.monotonic() < end:
            self._channel.send(say())
            again = time.monotonic() + pause
            while (left := again - time.monotonic()) > 0:
                packet = self._channel.receive(left)
                if packet is not None and wanted(got := Packet.read(packet)):
                    return got
            pause = min(2 * pause, 0.16)
        raise AssertionError(otherwise)

    def call(self, code: int, body: bytes = b"", times: int = 1) -> Packet:
        """The reply. `times` > 1: it is sent so often before anything is heard."""
        self._counter += 1
        counter, arrived = self._counter, False

        def say() -> bytes:
            return self._packet(QUERY if arrived else CALL, b"" if arrived else body, code, counter)

        def wanted(got: Packet) -> bool:
            nonlocal arrived
            if got.session != self._session or got.counter != counter:
                return False
            arrived = arrived or got.kind == PROGRESS
            return got.kind == REPLY

        for _ in range(times - 1):
            self._channel.send(say())
        return self._repeat(say, wanted, f"no reply to call {counter}")

    def close(self) -> Packet:
        return self._repeat(
            lambda: self._packet(GOODBYE), lambda got: got.kind == GOODBYE, "no goodbye"
        )


def function_code(name: str) -> int:
    value = 2166136261
    for byte in name.encode():
        value = (value ^ byte) * 16777619 % 2**32
    return value
