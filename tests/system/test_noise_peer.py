"""Our channel with PyPI's noiseprotocol at the other end, which shares no line with it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from cryptography.exceptions import InvalidTag
from noise.connection import Keypair, NoiseConnection

NAME = b"Noise_IK_25519_ChaChaPoly_SHA256"
PLACE = b"lcm:239.255.76.67:20017/GO"
PER_KEY = 3  # packets, as the speaker's rule says


class Speaker:
    """Our side, as a process that takes and gives lines."""

    def __init__(self, build: Path, *arguments: str) -> None:
        self._process = subprocess.Popen(
            [build / "tests/cpp/crypto/noise_speaker", *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )

    def say(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")

    def hear(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def ask(self, order: str, value: bytes) -> str:
        self.say(f"{order} {value.hex()}")
        return self.hear()

    def __enter__(self) -> Speaker:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._process.communicate(timeout=30)  # the end of its input is the end of it
        finally:
            self._process.kill()


class Peer:
    """noiseprotocol, and frames as ours write them: counter, ciphertext, tag."""

    def __init__(self, own_secret: bytes) -> None:
        self.noise = NoiseConnection.from_name(NAME)
        self.noise.set_prologue(PLACE)
        self.noise.set_keypair_from_private_bytes(Keypair.STATIC, own_secret)
        self._sent = self._heard_generation = 0

    def seal(self, text: bytes) -> bytes:
        state = self.noise.noise_protocol.cipher_state_encrypt
        generation, number = divmod(self._sent, PER_KEY)
        if number == 0 and generation > 0:
            state.rekey()
        self._sent += 1
        counter = generation << 32 | number
        state.set_nonce(counter)
        return counter.to_bytes(8, "big") + bytes(state.encrypt_with_ad(b"", text))

    def open(self, frame: bytes) -> bytes:
        state = self.noise.noise_protocol.cipher_state_decrypt
        counter = int.from_bytes(frame[:8], "big")
        while self._heard_generation < counter >> 32:
            state.rekey()
            self._heard_generation += 1
        state.set_nonce(counter)
        return bytes(state.decrypt_with_ad(b"", frame[8:]))


def public_of(secret: bytes) -> bytes:
    probe = NoiseConnection.from_name(NAME)
    probe.set_keypair_from_private_bytes(Keypair.STATIC, secret)
    return bytes(probe.noise_protocol.keypairs["s"].public_bytes)


def talk(ours: Speaker, theirs: Peer) -> None:
    """Ten packets each way: over three changes of the key."""
    for i in range(10):
        text = b"packet %d" % i
        assert bytes.fromhex(ours.ask("open", theirs.seal(text))) == text
        assert theirs.open(bytes.fromhex(ours.ask("seal", text))) == text
    late = theirs.seal(b"once")
    assert bytes.fromhex(ours.ask("open", late)) == b"once"
    assert ours.ask("open", late) == "refused"
    forged = bytearray(theirs.seal(b"forged"))
    forged[-1] ^= 1
    assert ours.ask("open", bytes(forged)) == "refused"
    assert bytes.fromhex(ours.ask("open", theirs.seal(b""))) == b""


def agreed(theirs: Peer, public: bytes) -> str:
    return f"peer is {public.hex()} binding {theirs.noise.get_handshake_hash().hex()}"


def test_noiseprotocol_opens_a_channel_to_ours(build: Path) -> None:
    our_secret, their_secret = os.urandom(32), os.urandom(32)
    theirs = Peer(their_secret)
    theirs.noise.set_keypair_from_public_bytes(Keypair.REMOTE_STATIC, public_of(our_secret))
    theirs.noise.set_as_initiator()
    theirs.noise.start_handshake()
    with Speaker(build, "responder", our_secret.hex(), PLACE.hex()) as ours:
        ours.say(theirs.noise.write_message(b"hello from Python").hex())
        assert theirs.noise.read_message(bytes.fromhex(ours.hear())) == b"gree"
        assert bytes.fromhex(ours.hear().removeprefix("peer says ")) == b"hello from Python"
        assert ours.hear() == agreed(theirs, public_of(their_secret))
        talk(ours, theirs)


def test_ours_opens_a_channel_to_noiseprotocol(build: Path) -> None:
    our_secret, their_secret = os.urandom(32), os.urandom(32)
    theirs = Peer(their_secret)
    theirs.noise.set_as_responder()
    theirs.noise.start_handshake()
    words = our_secret.hex(), public_of(their_secret).hex(), PLACE.hex()
    with Speaker(build, "initiator", *words) as ours:
        assert theirs.noise.read_message(bytes.fromhex(ours.hear())) == b"gree"
        ours.say(theirs.noise.write_message(b"welcome from Python").hex())
        assert bytes.fromhex(ours.hear().removeprefix("peer says ")) == b"welcome from Python"
        assert ours.hear() == agreed(theirs, public_of(their_secret))
        talk(ours, theirs)


def test_ours_refuses_a_client_that_means_another_place(build: Path) -> None:
    our_secret = os.urandom(32)
    theirs = Peer(os.urandom(32))
    theirs.noise.set_keypair_from_public_bytes(Keypair.REMOTE_STATIC, public_of(our_secret))
    theirs.noise.set_as_initiator()
    theirs.noise.start_handshake()
    with Speaker(build, "responder", our_secret.hex(), (PLACE + b"!").hex()) as ours:
        ours.say(theirs.noise.write_message().hex())
        assert ours.hear() == "refused"


def test_noiseprotocol_refuses_ours_when_it_means_another_place(build: Path) -> None:
    our_secret, their_secret = os.urandom(32), os.urandom(32)
    theirs = Peer(their_secret)
    theirs.noise.set_as_responder()
    theirs.noise.start_handshake()
    words = our_secret.hex(), public_of(their_secret).hex(), (PLACE + b"!").hex()
    with Speaker(build, "initiator", *words) as ours:
        first = bytes.fromhex(ours.hear())
        with pytest.raises(InvalidTag):
            theirs.noise.read_message(first)
        ours.say("00" * 48)  # no answer that it could take
        assert ours.hear() == "refused"
