"""The speaker as server: what is lost, doubled, late, forged or from elsewhere changes nothing."""

from __future__ import annotations

import copy

import pytest
from lines import Lossy, Through
from partner import Partner, code
from speaker.frames import HEADER, Frame, Header, Inner, SealedConnection
from speaker.frames import Kind as Datagram
from speaker.noise import GENERATIONS_AHEAD, WINDOW, Channel
from speaker.packets import Detail, Kind, Packet, u32
from speaker.tasks import Task
from told import Client


def sealed_reply(task: Task, number: int, session: int = 0, counter: int = 0) -> bytes:
    """A datagram that answers a read, to be published or not."""
    session, counter = session or task.session.id, counter or task.call.counter
    packet = Packet(Kind.REPLY, Detail.DONE, session=session, counter=counter, body=u32(number))
    return task.session.visitor.sealed.seal(Inner.PACKET, 1 << 40, packet.pack())


def asked(partner: Partner, client: Client) -> Task:
    """A read that waits for its answer."""
    partner.answers_by_hand("read")
    client.opens(partner.name)
    client.issues("a", "read 1")
    return partner.task("read")


def test_over_a_bad_line_every_command_is_carried_out_once(
    partner: Partner, client: Client
) -> None:
    line = partner.listener.line = Lossy(seed=7)
    client.opens(partner.name)
    client.acquires()
    many = 60
    for number in range(many):
        client.issues(f"m{number}", f"{'mark' if number % 2 else 'read'} {number}")
    client.issues("big", "mirror 60000")
    for number in range(many):
        assert client.ends(f"m{number}") == f"FINISHED DONE {number + 1}"
    assert client.ends("big") == "FINISHED DONE right"
    marks = [task.parameters for task in partner.tasks if task.operation.name == "mark"]
    assert marks == [u32(number) for number in range(1, many, 2)]  # in their order
    assert line.lost > 10


def test_a_call_is_repeated_as_it_was_until_it_is_answered(
    partner: Partner, client: Client
) -> None:
    said: list[Packet] = []

    def nothing(session: object, packet: Packet) -> list[Packet]:
        said.append(packet)
        return [packet] if packet.kind == Kind.WELCOME else []

    partner.mouth = nothing
    client.opens(partner.name)
    client.issues("a", "read 1")
    calls = partner.awaits(Kind.CALL, 5)
    assert len({call.pack() for call in calls}) == 1
    assert len({packet.pack() for packet in said if packet.kind == Kind.REPLY}) == 1
    assert len(partner.tasks) == 1
    partner.mouth = lambda session, packet: [packet]
    assert client.ends("a") == "FINISHED DONE 2"


def test_what_has_arrived_is_asked_for_and_not_sent_again(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    task.tell()
    partner.awaits(Kind.QUERY)
    calls = len(partner.packets(Kind.CALL))
    partner.awaits(Kind.QUERY, 4)
    assert len(partner.packets(Kind.CALL)) == calls
    assert {query.counter for query in partner.packets(Kind.QUERY)} == {1}
    task.done(u32(5))
    assert client.ends("a") == "FINISHED DONE 5"


def test_a_cancel_is_repeated_until_the_end(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.acquires()
    client.issues("a", "walk 1")
    client.stands("a", "EXECUTING")
    client.tell("cancel a")
    cancels = partner.awaits(Kind.CANCEL, 4)
    assert len({cancel.counter for cancel in cancels}) == 1
    partner.task("walk").fail(Detail.CANCELED, "at last")
    assert client.ends("a") == "COMMAND_FAILED CANCELED at last"


def test_a_packet_says_which_replies_have_come(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.issues("open", "exchange")
    partner.task("exchange")
    for number in range(3):
        client.issues("a", f"read {number}")
        client.ends("a")
    assert {packet.acknowledged for packet in partner.packets(Kind.CALL)} == {0}
    partner.task("exchange").fail(Detail.REJECTED, "no")
    client.ends("open")
    client.issues("b", "read 9")
    client.ends("b")
    assert partner.packets(Kind.CALL)[-1].acknowledged == 4


def test_a_forged_cut_or_clear_datagram_changes_nothing(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    publish = task.session.visitor.publish
    good = sealed_reply(task, 6)
    for at in (2, 3, 8, 15, *range(HEADER, len(good))):
        bad = bytearray(good)
        bad[at] ^= 1
        publish(bytes(bad))
    for size in range(len(good)):
        publish(good[:size])
    clear = Packet(Kind.REPLY, Detail.DONE, session=task.session.id, counter=1, body=u32(7)).pack()
    for payload in (clear, good[:HEADER] + clear, good[:HEADER] + bytes(8) + clear, b"", b"\0" * 8):
        publish(payload)
    partner.awaits(Kind.CALL, len(partner.packets(Kind.CALL)) + 1)  # it asks on
    publish(good)  # as it is, it counts: the forgeries were near enough
    assert client.ends("a") == "FINISHED DONE 6"
    publish(good)
    client.issues("b", "read 2")
    partner.task("read", 1).done(u32(8))
    assert client.ends("b") == "FINISHED DONE 8"


def test_an_answer_to_another_call_or_session_is_none(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    publish = task.session.visitor.publish
    for counter in (2, 7, 2**63, 2**64 - 1):
        publish(sealed_reply(task, 99, counter=counter))
    publish(sealed_reply(task, 99, session=task.session.id + 1))
    zero = Packet(Kind.REPLY, Detail.DONE, session=task.session.id, body=u32(99))
    task.session.visitor.sealed.send_packet(zero.pack())
    task.done(u32(6))
    assert client.ends("a") == "FINISHED DONE 6"
    client.issues("b", "read 1")  # counter 2, which was answered before it was asked
    partner.task("read", 1).done(u32(7))
    assert client.ends("b") == "FINISHED DONE 7"


def test_a_reply_that_comes_again_changes_nothing(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    task.done(u32(6))
    assert client.ends("a") == "FINISHED DONE 6"
    again = Packet(Kind.REPLY, Detail.FAULT, counter=task.call.counter, body=b"")
    task.session.send(again)
    task.session.send(task.standing())
    client.issues("p", "ping")
    client.ends("p")
    assert client.stands("a", "DONE")


@pytest.mark.parametrize("ahead", [1, GENERATIONS_AHEAD])
def test_a_key_of_a_later_generation_is_taken(ahead: int, partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    before = sealed_reply(task, 5)
    for _ in range(ahead):
        task.session.visitor.sealed.channel.sealer.turn_over()
    task.tell()
    partner.awaits(Kind.QUERY)  # it has opened the new generation
    task.session.visitor.publish(before)  # the one before is good for a second more
    assert client.ends("a") == "FINISHED DONE 5"
    client.issues("b", "read 1")
    partner.task("read", 1).done(u32(6))
    assert client.ends("b") == "FINISHED DONE 6"


def test_a_key_of_nine_generations_ahead_is_not_taken(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    sealed = task.session.visitor.sealed
    ahead = copy.copy(sealed.channel.sealer)
    for _ in range(GENERATIONS_AHEAD + 1):
        ahead.turn_over()
    far = SealedConnection(
        Channel(ahead, sealed.channel.opener), sealed.header, task.session.visitor.publish
    )
    reply = Packet(Kind.REPLY, Detail.DONE, session=task.session.id, counter=1, body=u32(9))
    far.send_packet(reply.pack())
    task.done(u32(6))
    assert client.ends("a") == "FINISHED DONE 6"


@pytest.mark.parametrize(("behind", "value"), [(WINDOW - 1, 5), (WINDOW, 6)])
def test_of_late_packets_the_last_1024_are_taken(
    behind: int, value: int, partner: Partner, client: Client
) -> None:
    task = asked(partner, client)
    visitor = task.session.visitor
    late = sealed_reply(task, 5)
    visitor.sealed.channel.sealer.number += behind - 1  # numbers that nobody ever sees
    visitor.sealed.send(Inner.BEAT)
    visitor.publish(late)
    task.done(u32(6))
    assert client.ends("a") == f"FINISHED DONE {value}"


def test_frames_and_packets_of_unknown_kinds_are_dropped(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    sealed = task.session.visitor.sealed
    for kind in (0, 5, 7, 99, 255):
        sealed.send(kind, 1, b"whatever")
    for short in range(25 - 8):
        text = Frame(Inner.BEAT, 0, 0, b"").pack()[:short]
        header = Header(Datagram.SEALED, 0, task.session.visitor.client).pack()
        task.session.visitor.publish(header + sealed.channel.sealer.seal(header, text))
    for kind in (0, 1, 4, 7, 8, 9, 10, 12, 13, 14, 15, 16, 17, 127, 128, 255):
        task.session.send(Packet(kind, counter=1, body=u32(4)))
    good = Packet(Kind.REPLY, Detail.DONE, session=task.session.id, counter=1, body=u32(4)).pack()
    for bad in (good[:-1], good + b"\0", bytes([0x91]) + good[1:], good[:60], b"", good[:8]):
        sealed.send_packet(bad)
    task.session.send(Packet(Kind.REPLY, Detail.DONE, counter=1, body=u32(4), version=2))
    task.done(u32(6))
    assert client.ends("a") == "FINISHED DONE 6"


def test_pieces_that_lie_are_dropped(partner: Partner, client: Client) -> None:
    task = asked(partner, client)
    sealed = task.session.visitor.sealed
    mark = bytes.fromhex("6765636f73207031")
    for transfer, size, index, piece in (
        (1, 0, 0, b""),  # no packet is empty
        (1, 20_000, 0, b"x" * 8191),
        (1, 20_000, 2, b"x" * 8192),
        (1, 20_000, 3, b"x" * 8192),
        (1, 8 * 2**20 + 1, 0, b"x" * 8192),
        (1, 2**32 - 1, 2**32 - 1, b"x"),
        (0, 20_000, 0, b"x" * 8192),
        (2**64 - 1, 20_000, 0, b"x" * 8191),
    ):
        head = mark + transfer.to_bytes(8, "big") + size.to_bytes(4, "big")
        sealed.send(Inner.PACKET, 1, head + index.to_bytes(4, "big") + piece)
    answer = bytes.fromhex("6765636f73206131")
    for what in (bytes(16), b"\xff" * 16, b"", b"\xff" * 15, b"\xff" * 17):
        sealed.send(Inner.PACKET, 1, answer + what)
    task.done(u32(6))
    assert client.ends("a") == "FINISHED DONE 6"
    client.issues("b", "mirror 30000")
    assert client.ends("b") == "FINISHED DONE right"


def test_what_comes_before_an_earlier_call_waits_for_it(partner: Partner, client: Client) -> None:
    late: list[Packet] = []

    def all_but_the_first(session: object, packet: Packet) -> list[Packet]:
        if packet.code != code("mark") or late or packet.body != u32(0):
            return [packet]
        late.append(packet)
        return []

    partner.ear = all_but_the_first
    client.opens(partner.name)
    client.acquires()
    client.issues("a", "mark 0")
    client.issues("b", "mark 10")
    assert client.ends("a") == "FINISHED DONE 1"
    assert client.ends("b") == "FINISHED DONE 11"
    assert late and [task.parameters for task in partner.tasks] == [u32(0), u32(10)]


def test_a_second_that_is_forged_does_not_hinder_the_real_one(
    partner: Partner, client: Client
) -> None:
    forged: list[bytes] = []

    def before(payload: bytes) -> list[bytes]:
        header = Header.of(payload)
        if header is None or header.kind != Datagram.SECOND or forged:
            return [payload]
        for at in range(HEADER, len(payload)):
            forged.append(payload[:at] + bytes([payload[at] ^ 0x40]) + payload[at + 1 :])
        cut = [payload[:size] for size in range(HEADER, len(payload))]
        return [*forged, *cut, payload + b"\0", payload]

    partner.listener.line = Through(before)
    client.opens(partner.name)
    assert len(forged) == 48
    client.issues("a", "read 1")
    assert client.ends("a") == "FINISHED DONE 2"
