"""The examples of docs/protocol.md are what the speaker says."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from speaker import frames, lcm, packets
from speaker.frames import Frame, Header, Inner, Kind
from speaker.noise import Initiation, Keys, accept, public_of
from speaker.packets import Detail, Failure, Hello, Packet, Progress, Welcome
from speaker.streams import InwardSample

TREE = Path(__file__).resolve().parents[2]

CLIENT, SERVER = bytes([0x11]) * 32, bytes([0x22]) * 32
CLIENT_EPHEMERAL, SERVER_EPHEMERAL = bytes([0x33]) * 32, bytes([0x44]) * 32
NUMBER, PORT = 0x0102030405060708, 20001
PLACE = "lcm:239.255.76.67:20017/GO0123456789abcdef"


def examples() -> dict[str, bytes]:
    text = (TREE / "docs" / "protocol.md").read_text()
    blocks = re.findall(r"^```hex ([\w ]+)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return {
        name: bytes.fromhex("".join(line.split()[0] for line in block.splitlines()))
        for name, block in blocks
    }


EXAMPLES = examples()


def header(kind: Kind, port: int = PORT) -> bytes:
    return Header(kind, port, NUMBER).pack()


def test_ask() -> None:
    assert lcm.datagram(7, "GWBROKER", header(Kind.ASK)) == EXAMPLES["ask"]


def test_handshake_and_the_first_beats() -> None:
    first_header = header(Kind.FIRST)
    began = Initiation(CLIENT, public_of(SERVER), PLACE, first_header, CLIENT_EPHEMERAL)
    assert first_header + began.first == EXAMPLES["first"]
    keys = Keys(SERVER, frozenset({public_of(CLIENT)}))
    accepted = accept(keys, PLACE, first_header, began.first, SERVER_EPHEMERAL)
    assert accepted is not None and accepted.client == public_of(CLIENT)
    assert header(Kind.SECOND, 0) + accepted.second == EXAMPLES["second"]
    ours = began.finish(accepted.second)
    assert ours is not None
    for channel, port, name, at in (
        (ours, PORT, "client beat", 1_000_000_000),
        (accepted.channel, 0, "server beat", 2_000_000_000),
    ):
        sent: list[bytes] = []
        sealed = frames.SealedConnection(channel, Header(Kind.SEALED, port, NUMBER), sent.append)
        assert sealed.seal(Inner.BEAT, 0, b"", at) == EXAMPLES[name]
    beat = EXAMPLES["server beat"]
    text = ours.opener.open(beat[:16], beat[16:])
    assert text is not None and Frame.of(text) == Frame(Inner.BEAT, 0, 2_000_000_000, b"")
    assert ours.opener.open(beat[:16], beat[16:]) is None  # once only


def test_a_stranger_is_not_accepted() -> None:
    first_header = header(Kind.FIRST)
    began = Initiation(CLIENT, public_of(SERVER), PLACE, first_header)
    assert accept(Keys(SERVER, frozenset()), PLACE, first_header, began.first) is None


HELLO = Hello("eva", "lab", "demo", 42, 5, "gecos::Broker", 0, 750_000_000)
WELCOME = Welcome("BROKER", "gecos::Broker", [], 0x1234, 6, 256, {0x8CE83919: 0x77})
LOOKUP = packets.code_of("gecos::Broker::lookup")
UNKNOWN = packets.string("RX90") + packets.sequence([packets.string("BROKER")])
NOT_A_BROKER = Failure("RX90 is a robcl::Rx90, not a gecos::Broker")
ACQUIRE = packets.u32(1) + packets.boolean(True) + packets.string("two hands") + packets.f64(0.0)
GRANT = packets.block(packets.u32(1) + packets.u64(11))

PACKETS = {
    "hello": Packet(packets.Kind.HELLO, body=HELLO.pack()),
    "welcome": Packet(packets.Kind.WELCOME, session=9, body=WELCOME.pack()),
    "refused": Packet(packets.Kind.REFUSED, detail=Detail.REFUSED, body=NOT_A_BROKER.pack()),
    "call": Packet(
        packets.Kind.CALL,
        code=LOOKUP,
        session=9,
        counter=3,
        acknowledged=2,
        deadline_ns=2_000_000_000,
        body=packets.string("RX90"),
    ),
    "reply": Packet(
        packets.Kind.REPLY,
        detail=Detail.FAULT,
        session=9,
        counter=3,
        body=Failure("unknown", "gecos::UnknownName", UNKNOWN).pack(),
    ),
    "progress": Packet(
        packets.Kind.PROGRESS,
        detail=Detail.QUEUED,
        session=9,
        counter=3,
        body=Progress(1, 0.0).pack(),
    ),
    "acquire": Packet(
        packets.Kind.CALL,
        code=packets.ACQUIRE,
        session=9,
        counter=4,
        acknowledged=3,
        body=ACQUIRE,
    ),
    "granted": Packet(packets.Kind.REPLY, detail=Detail.DONE, session=9, counter=4, body=GRANT),
    "goodbye": Packet(packets.Kind.GOODBYE, session=9, acknowledged=4),
}


@pytest.mark.parametrize("name", PACKETS)
def test_packet(name: str) -> None:
    assert PACKETS[name].pack() == EXAMPLES[name]
    assert Packet.of(EXAMPLES[name]) == PACKETS[name]


@pytest.mark.parametrize("name", PACKETS)
def test_a_packet_that_is_cut_or_longer_is_none(name: str) -> None:
    raw = EXAMPLES[name]
    for size in range(len(raw)):
        with pytest.raises(packets.Malformed):
            Packet.of(raw[:size])
    with pytest.raises(packets.Malformed):
        Packet.of(raw + b"\0")


def test_an_inward_sample() -> None:
    sample = InwardSample(9, 11, 4, packets.f64(0.25) + packets.u64(2_000_000_000))
    assert sample.pack() == EXAMPLES["inward sample"]
    vectors = json.loads((TREE / "tests" / "vectors" / "inward_sample.json").read_text())
    assert vectors["accepted"] and vectors["refused"]
    for case in vectors["accepted"]:
        numbers = case["session"], case["epoch"], case["command"]
        sample = InwardSample(*numbers, bytes.fromhex(case["value"]))
        assert sample.pack().hex() == case["bytes"]
        assert InwardSample.of(sample.pack()) == sample
    for case in vectors["refused"]:
        assert InwardSample.of(bytes.fromhex(case["bytes"])) is None


def test_bodies_are_read_as_they_were_written() -> None:
    assert Hello.of(PACKETS["hello"].body) == HELLO
    assert Welcome.of(PACKETS["welcome"].body) == WELCOME
    assert Failure.of(PACKETS["refused"].body) == NOT_A_BROKER


@pytest.mark.parametrize("lost", [(), (0, 5, 6, 21), tuple(range(0, 60, 2))])
def test_a_large_packet_arrives_once_whatever_is_lost(lost: tuple[int, ...]) -> None:
    packet = bytes(i * 7 % 256 for i in range(20 * frames.SMALL + 3))
    arrived: list[bytes] = []
    sent = 0
    answers: list[bytes] = []
    receiver = frames.PiecesIn(answers.append)
    wire: list[bytes] = []
    sender = frames.PiecesOut(wire.append)
    sender.put(packet)
    now = 1e12  # far ahead: every look finds that nothing came for 20 ms
    while not arrived or wire:
        if not wire:
            sender.tick(now)
            now += 1.0
        piece = wire.pop(0)
        sent += 1
        if sent - 1 in lost:
            continue
        for _ in range(2):  # the medium may deliver twice
            whole = receiver.take(piece)
            if whole is not None:
                arrived.append(whole)
        while answers:
            sender.received(answers.pop(0))
    assert arrived == [packet]
