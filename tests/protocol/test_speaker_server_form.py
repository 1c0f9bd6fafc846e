"""What our clients send is laid out as the document says, and nothing else is sent."""

from __future__ import annotations

import struct

from partner import Partner, code
from speaker.frames import HEADER, Header, Inner
from speaker.frames import Kind as Datagram
from speaker.listener import Line
from speaker.packets import Kind, Packet, f64, u32
from told import Client

FROM_CLIENTS = {Kind.HELLO, Kind.CALL, Kind.CANCEL, Kind.QUERY, Kind.GOODBYE}


class Witness(Line):
    """Keeps what came."""

    def __init__(self) -> None:
        self.came: list[bytes] = []

    def inward(self, payload: bytes) -> list[bytes]:
        self.came.append(payload)
        return [payload]


def a_session_with_everything(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.issues("r", "read 1")
    client.ends("r")
    client.tell("deadline 20")
    client.acquires()
    client.issues("w", "walk 1")
    client.stands("w", "EXECUTING")
    client.tell("cancel w")
    client.stands("w", "CANCELING")
    partner.awaits(Kind.QUERY)
    partner.task("walk").done(bytes(4))
    client.ends("w")
    client.tell("follow")
    client.says("follows")
    client.tell("release")
    client.says("released")
    client.tell("close")
    client.says("closed")
    partner.loop.until(lambda: partner.session.visitor.bye, "Bye")


def test_every_datagram_has_its_form(partner: Partner, client: Client) -> None:
    witness = partner.listener.line = Witness()
    a_session_with_everything(partner, client)
    headers = [Header.of(payload) for payload in witness.came]
    assert all(header is not None for header in headers)
    known = [header for header in headers if header is not None]
    assert {header.kind for header in known} == {Datagram.FIRST, Datagram.SEALED}
    assert len({(header.reply_port, header.client) for header in known}) == 1
    assert 20000 <= known[0].reply_port <= 32000 and known[0].client != 0
    assert all(payload[6:8] == b"\0\0" for payload in witness.came)
    sealed = [p for p in witness.came if p[3] == Datagram.SEALED]
    counters = [int.from_bytes(payload[HEADER : HEADER + 8], "big") for payload in sealed]
    assert counters == list(range(len(sealed)))  # each once, from 0
    assert {len(p) - HEADER for p in witness.came if p[3] == Datagram.FIRST} == {96}


def test_every_frame_has_its_form(partner: Partner, client: Client) -> None:
    a_session_with_everything(partner, client)
    frames = partner.session.frames
    assert {frame.kind for frame in frames} == {Inner.PACKET, Inner.BEAT, Inner.OPENED}
    packets = [frame.number for frame in frames if frame.kind == Inner.PACKET]
    assert packets == list(range(1, len(packets) + 1))
    assert {frame.number for frame in frames if frame.kind == Inner.BEAT} == {0}
    assert {frame.number for frame in frames if frame.kind == Inner.OPENED} == {1}
    others = [frame.body for frame in frames if frame.kind != Inner.PACKET]
    assert set(others) == {b""}
    sent = [frame.sent_ns for frame in frames]
    assert sent == sorted(sent)


def test_every_packet_has_its_form(partner: Partner, client: Client) -> None:
    a_session_with_everything(partner, client)
    came = partner.session.received
    assert {packet.kind for packet in came} == FROM_CLIENTS
    session, counters = partner.session.id, set()
    for packet in came:
        assert (packet.version, packet.detail) == (1, 0)
        assert packet.session == (0 if packet.kind == Kind.HELLO else session)
        assert (packet.code != 0) == (packet.kind == Kind.CALL)
        assert (packet.counter != 0) == (packet.kind in (Kind.CALL, Kind.CANCEL, Kind.QUERY))
        assert bool(packet.body) <= (packet.kind in (Kind.HELLO, Kind.CALL, Kind.CANCEL))
        if packet.kind == Kind.CANCEL:
            (last,) = struct.unpack(">Q", packet.body)  # the call that was issued last
            assert packet.counter <= last <= len(partner.packets(Kind.CALL))
        assert packet.acknowledged < max(packet.counter, len(partner.packets(Kind.CALL)) + 1)
        if packet.kind != Kind.CALL:
            assert (packet.epoch, packet.deadline_ns) == (0, 0)
        else:
            counters.add(packet.counter)
    assert counters == set(range(1, len(counters) + 1))
    deadlines = {call.code: call.deadline_ns for call in partner.packets(Kind.CALL)}
    walked = partner.task("walk").call
    assert 0 < walked.deadline_ns <= 20 * 10**9 and deadlines[walked.code] > 0


def test_packets_of_reserved_kinds_are_dropped(partner: Partner, client: Client) -> None:
    partner.answers_by_hand("read")
    client.opens(partner.name)
    client.tell("follow")
    client.says("follows")
    client.issues("a", "read 1")
    task = partner.task("read")
    about = {"code": code("level"), "session": task.session.id, "counter": task.call.counter}
    for kind in (0, 8, 9, 10, 13, 14, 15, 16, 17, 127, 255):
        task.session.visitor.sealed.send_packet(Packet(kind, 5, **about).pack())
    for number in (1, 2):
        partner.level.publish(partner.level.seal(f64(number)))
        assert client.says("sample") == f"{number} 0 {number}"
    task.done(u32(7))
    assert client.ends("a") == "FINISHED DONE 7"


def test_the_reserved_byte_of_a_packet_is_not_looked_at(partner: Partner, client: Client) -> None:
    def with_reserved(raw: bytes) -> bytes:
        return raw[:11] + b"\x5a" + raw[12:]

    partner.answers_by_hand("read")
    client.opens(partner.name)
    client.issues("a", "read 1")
    task = partner.task("read")
    reply = Packet(Kind.REPLY, 5, session=task.session.id, counter=1, body=struct.pack(">I", 7))
    task.session.visitor.sealed.send_packet(with_reserved(reply.pack()))
    assert client.ends("a") == "FINISHED DONE 7"
