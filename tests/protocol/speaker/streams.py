"""Streams: what a Share says, and samples that one server seals for all its readers."""

from __future__ import annotations

import hashlib
import secrets
import struct
import time
from collections import deque
from dataclasses import dataclass, replace

from cryptography.exceptions import InvalidSignature, InvalidTag
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305

from .frames import HEADER, Header, Kind
from .lcm import Ear, Mouth
from .noise import nonce_of

_SHARE = struct.Struct(">IIHHQ32s32s")
_STAMP = struct.Struct(">q")
SIGNATURE = 64
TAG = 16


def channel_of(number: int) -> str:
    return f"GS{number:016x}"


@dataclass(frozen=True, slots=True)
class Share:
    id: int
    largest: int
    keep: int
    port: int
    number: int
    key: bytes
    signer: bytes

    def pack(self) -> bytes:
        where = self.id, self.largest, self.keep, self.port, self.number
        return _SHARE.pack(*where, self.key, self.signer)

    @staticmethod
    def of(body: bytes) -> Share | None:
        if len(body) != _SHARE.size:
            return None
        share = Share(*_SHARE.unpack(body))
        return share if 1 <= share.keep <= 1024 and share.port else None


@dataclass(frozen=True, slots=True)
class Sample:
    sequence: int
    stamp_ns: int
    value: bytes


_INWARD = struct.Struct(">3Q")


@dataclass(frozen=True, slots=True)
class InwardSample:
    """What a client sends inward: whose the value is, and the value with the time of its
    measurement."""

    session: int
    epoch: int
    command: int
    value: bytes

    def pack(self) -> bytes:
        return _INWARD.pack(self.session, self.epoch, self.command) + self.value

    @staticmethod
    def of(sample: bytes) -> InwardSample | None:
        """None where the header is cut short."""
        if len(sample) < _INWARD.size:
            return None
        session, epoch, command = _INWARD.unpack_from(sample)
        return InwardSample(session, epoch, command, sample[_INWARD.size :])


def _signed(counter: bytes, header: bytes, text: bytes) -> bytes:
    text = b"gecos stream 1" + counter + struct.pack(">Q", len(header)) + header + text
    return hashlib.blake2b(text).digest()


def seal(share: Share, signer: Ed25519PrivateKey, counter: int, value: bytes) -> bytes:
    """The datagram of a sample that is measured now."""
    header = Header(Kind.SAMPLE, 0, 0).pack()
    raw = counter.to_bytes(8, "big")
    text = _STAMP.pack(time.time_ns()) + value + _STAMP.pack(time.monotonic_ns())
    text += signer.sign(_signed(raw, header, text))
    return header + raw + ChaCha20Poly1305(share.key).encrypt(nonce_of(counter), text, header)


def open_sample(share: Share, payload: bytes) -> Sample | None:
    """None where it does not open or is not signed by the server."""
    header, raw, sealed = payload[:HEADER], payload[HEADER : HEADER + 8], payload[HEADER + 8 :]
    counter = int.from_bytes(raw, "big")
    if len(sealed) < 2 * _STAMP.size + SIGNATURE + TAG:
        return None
    try:
        text = ChaCha20Poly1305(share.key).decrypt(nonce_of(counter), sealed, header)
        text, signature = text[:-SIGNATURE], text[-SIGNATURE:]
        key = Ed25519PublicKey.from_public_bytes(share.signer)
        key.verify(signature, _signed(raw, header, text))
    except (InvalidTag, InvalidSignature):
        return None
    (stamp,) = _STAMP.unpack_from(text)
    return Sample(counter + 1, stamp, text[_STAMP.size : -_STAMP.size])


class StreamWriter:
    """One stream of a server, sent once for all its readers."""

    def __init__(self, mouth: Mouth, largest: int, keep: int = 8) -> None:
        self._mouth = mouth
        self._signer = Ed25519PrivateKey.generate()
        where = largest, keep, 20000 + secrets.randbelow(12001), secrets.randbits(64)
        signer = self._signer.public_key().public_bytes_raw()
        self._shared = Share(0, *where, secrets.token_bytes(32), signer)
        self._counter = 0
        self.last = b""
        """The newest datagram."""

    @property
    def newest(self) -> int:
        """The sequence number of the newest sample, 0 before the first."""
        return self._counter

    def share(self, number: int) -> Share:
        return replace(self._shared, id=number)

    def seal(self, value: bytes, skip: int = 0) -> bytes:
        """The datagram of the next sample, or of a later one."""
        self._counter += skip
        self.last = seal(self._shared, self._signer, self._counter, value)
        self._counter += 1
        return self.last

    def publish(self, payload: bytes) -> None:
        self._mouth.publish(self._shared.port, channel_of(self._shared.number), payload)

    def again(self) -> None:
        if self.last:
            self.publish(self.last)


class StreamReader:
    """Hears one stream; takes part in a loop."""

    def __init__(self, share: Share) -> None:
        self.share = share
        self.ear = Ear(share.port, channel_of(share.number))
        self.samples: deque[Sample] = deque(maxlen=share.keep)
        self.dropped = 0
        self.last: bytes = b""
        """The newest datagram that counted."""
        self._newest = 0

    def heard(self, payload: bytes) -> None:
        header = Header.of(payload)
        if header is None or header.kind != Kind.SAMPLE:
            return
        sample = open_sample(self.share, payload)
        if sample is None or sample.sequence <= self._newest:
            self.dropped += 1
            return
        self._newest = sample.sequence
        self.last = payload
        self.samples.append(sample)

    def tick(self, now: float) -> None:
        pass
