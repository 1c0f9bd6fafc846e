"""Keys and the two sealed directions of a connection (docs/protocol.md, Channel)."""

from __future__ import annotations

import hashlib
import time
import warnings
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
from noise.connection import Keypair, NoiseConnection

NAME = b"Noise_IK_25519_ChaChaPoly_SHA256"
PROLOGUE = b"gecos lcm 2"
GENERATION_PACKETS = 1 << 24
GENERATION_S = 120.0
WINDOW = 1024
GENERATIONS_AHEAD = 8


@dataclass(frozen=True, slots=True)
class Keys:
    """A user: the own pair, and who is admitted."""

    secret: bytes
    admitted: frozenset[bytes]

    @property
    def public(self) -> bytes:
        return public_of(self.secret)

    def admits(self, key: bytes) -> bool:
        return key == self.public or key in self.admitted


def public_of(secret: bytes) -> bytes:
    return X25519PrivateKey.from_private_bytes(secret).public_key().public_bytes_raw()


def key_line(word: str, key: bytes) -> str:
    text = f"{word} {key.hex()} "
    return text + hashlib.sha256(text.encode()).hexdigest()[:8] + "\n"


def write_key_folder(folder: Path, keys: Keys) -> None:
    """The folder that programs take by GECOS_KEY_DIR."""
    folder.mkdir(mode=0o700)
    own = folder / "own.secret"
    own.touch(mode=0o600)
    own.write_text(key_line("gecos-secret-1", keys.secret))
    for key in {keys.public, *keys.admitted}:
        (folder / f"{key.hex()}.public").write_text(key_line("gecos-public-1", key))


def nonce_of(counter: int) -> bytes:
    return bytes(4) + counter.to_bytes(8, "little")


def next_key(key: bytes) -> bytes:
    """Noise's REKEY."""
    return ChaCha20Poly1305(key).encrypt(nonce_of(2**64 - 1), bytes(32), b"")[:32]


class Sealer:
    """One direction, at the side that sends."""

    def __init__(self, key: bytes) -> None:
        self._key = key
        self.generation = 0
        self.number = 0
        self._since = time.monotonic()

    def turn_over(self) -> None:
        """The next generation of the key begins."""
        self._key = next_key(self._key)
        self.generation += 1
        self.number = 0
        self._since = time.monotonic()

    def seal(self, header: bytes, text: bytes) -> bytes:
        age = time.monotonic() - self._since
        if self.number >= GENERATION_PACKETS or age >= GENERATION_S:
            self.turn_over()
        counter = self.generation << 32 | self.number
        self.number += 1
        sealed = ChaCha20Poly1305(self._key).encrypt(nonce_of(counter), text, header)
        return counter.to_bytes(8, "big") + sealed


class Window:
    """Which of the last 1,024 numbers have come."""

    def __init__(self) -> None:
        self._newest = -1
        self._come = 0  # bit i: newest - i

    def fresh(self, number: int) -> bool:
        behind = self._newest - number
        return behind < 0 or (behind < WINDOW and not self._come >> behind & 1)

    def take(self, number: int) -> None:
        ahead = number - self._newest
        if ahead > 0:
            self._come = (self._come << ahead | 1) & ((1 << WINDOW) - 1)
            self._newest = number
        else:
            self._come |= 1 << -ahead


class Opener:
    """One direction, at the side that receives: each packet once, forged ones never."""

    def __init__(self, key: bytes) -> None:
        self._keys = {0: key}
        self._windows = {0: Window()}
        self._newest = 0

    def open(self, header: bytes, sealed: bytes) -> bytes | None:
        if len(sealed) < 24:
            return None
        counter = int.from_bytes(sealed[:8], "big")
        generation, number = counter >> 32, counter & 0xFFFFFFFF
        if generation > self._newest + GENERATIONS_AHEAD:
            return None
        key = self._key_of(generation)
        window = self._windows.get(generation, Window())
        if key is None or not window.fresh(number):
            return None
        try:
            text = ChaCha20Poly1305(key).decrypt(nonce_of(counter), sealed[8:], header)
        except InvalidTag:
            return None
        window.take(number)
        self._windows[generation] = window
        if generation > self._newest:
            self._advance(generation, key)
        return text

    def _key_of(self, generation: int) -> bytes | None:
        if generation <= self._newest:
            return self._keys.get(generation)
        key = self._keys[self._newest]
        for _ in range(generation - self._newest):
            key = next_key(key)
        return key

    def _advance(self, generation: int, key: bytes) -> None:
        """Keeps the one that was the newest, for what it sealed may still be on its way."""
        self._keys = {self._newest: self._keys[self._newest], generation: key}
        self._windows = {g: w for g, w in self._windows.items() if g in self._keys}
        self._newest = generation


@dataclass(frozen=True, slots=True)
class Channel:
    """Both directions of a connection, of one side."""

    sealer: Sealer
    opener: Opener


def channel_of(noise: NoiseConnection) -> Channel:
    protocol = noise.noise_protocol
    return Channel(Sealer(protocol.cipher_state_encrypt.k), Opener(protocol.cipher_state_decrypt.k))


def _start(secret: bytes, place: str, first_header: bytes, ephemeral: bytes) -> NoiseConnection:
    noise = NoiseConnection.from_name(NAME)
    noise.set_prologue(PROLOGUE + place.encode() + first_header)
    noise.set_keypair_from_private_bytes(Keypair.STATIC, secret)
    if ephemeral:
        noise.set_keypair_from_private_bytes(Keypair.EPHEMERAL, ephemeral)
    return noise


def _begin(noise: NoiseConnection) -> None:
    with warnings.catch_warnings():  # an ephemeral key of our own: drawn here, or by an example
        warnings.simplefilter("ignore", UserWarning)
        noise.start_handshake()


class Initiation:
    """The client's half of the handshake: `first` goes out, a Second makes the channel."""

    def __init__(
        self, secret: bytes, server: bytes, place: str, first_header: bytes, ephemeral: bytes = b""
    ) -> None:
        self._start = partial(_start, secret, place, first_header)
        self._server = server
        self._ephemeral = ephemeral or X25519PrivateKey.generate().private_bytes_raw()
        self.first = bytes(self._noise().write_message())

    def _noise(self) -> NoiseConnection:
        noise = self._start(self._ephemeral)
        noise.set_keypair_from_public_bytes(Keypair.REMOTE_STATIC, self._server)
        noise.set_as_initiator()
        _begin(noise)
        return noise

    def finish(self, second: bytes) -> Channel | None:
        """Nothing changes by a Second that is not valid: each is tried on a state of its own."""
        noise = self._noise()
        noise.write_message()
        try:
            noise.read_message(second)
        except (InvalidTag, ValueError):
            return None
        return channel_of(noise)


@dataclass(frozen=True, slots=True)
class Accepted:
    channel: Channel
    client: bytes
    second: bytes


def accept(
    keys: Keys, place: str, first_header: bytes, first: bytes, ephemeral: bytes = b""
) -> Accepted | None:
    """The server's half; None where First is not valid or its sender not admitted."""
    noise = _start(keys.secret, place, first_header, ephemeral)
    noise.set_as_responder()
    _begin(noise)
    try:
        noise.read_message(first)
    except (InvalidTag, ValueError):
        return None
    client = bytes(noise.noise_protocol.handshake_state.rs.public_bytes)
    if not keys.admits(client):
        return None
    second = bytes(noise.write_message())
    return Accepted(channel_of(noise), client, second)
