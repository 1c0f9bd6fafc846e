"""The speaker as server that does not open a session, or another one than was wanted."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import replace

from lines import Through
from partner import Partner, code
from speaker.frames import HEADER, Header
from speaker.frames import Kind as Datagram
from speaker.noise import Keys
from speaker.packets import Detail, Failure, Kind, Packet
from told import Client


def not_opened(partner: Partner, client: Client, patience: float = 0.5) -> str:
    client.tell(f"open {partner.name} {patience}")
    return client.says("not opened:")


def answered(partner: Partner, change: Callable[[Packet], list[Packet]]) -> None:
    """Each Welcome becomes what `change` makes of it."""
    partner.mouth = lambda session, packet: (
        change(packet) if packet.kind == Kind.WELCOME else [packet]
    )


def test_a_refusal_is_told_with_its_reason(partner: Partner, client: Client) -> None:
    refused = Failure("not on a Sunday").pack()
    for version in (1, 2):  # whoever speaks another version can only refuse
        no = Packet(Kind.REFUSED, Detail.REFUSED, body=refused, version=version)
        answered(partner, lambda welcome, no=no: [no])
        why = not_opened(partner, client, 5.0)
        assert "REFUSED" in why and "not on a Sunday" in why


def test_a_server_of_another_version_does_not_answer(partner: Partner, client: Client) -> None:
    answered(partner, lambda welcome: [replace(welcome, version=2)])
    why = not_opened(partner, client)
    assert "NO_SERVER" in why and "did not answer" in why
    answered(partner, lambda welcome: [welcome])
    client.opens(partner.name)


def test_datagrams_of_another_version_are_not_heard(partner: Partner, client: Client) -> None:
    partner.listener.line = Through(lambda sent: [sent[:2] + b"\x03" + sent[3:]])
    why = not_opened(partner, client)
    assert "NO_SERVER" in why and "did not answer" in why


def test_a_server_with_another_key_than_the_brokers_list_says_is_not_spoken_to(
    partner: Partner, client: Client
) -> None:
    partner.listener.keys = Keys(secrets.token_bytes(32), partner.listener.keys.admitted)
    assert "NO_SERVER" in not_opened(partner, client)
    assert not partner.sessions


def test_who_does_not_admit_the_client_is_not_answered(partner: Partner, client: Client) -> None:
    partner.listener.keys = Keys(partner.listener.keys.secret, frozenset())
    why = not_opened(partner, client)
    assert "NO_SERVER" in why
    assert not partner.sessions


def test_hello_is_repeated_until_it_is_answered(partner: Partner, client: Client) -> None:
    heard: list[Packet] = []

    def the_fourth(welcome: Packet) -> list[Packet]:
        heard.append(welcome)
        return [welcome] * 3 if len(heard) == 4 else []

    answered(partner, the_fourth)
    client.opens(partner.name)
    hellos = partner.packets(Kind.HELLO)
    assert len(hellos) == 4 and len({hello.pack() for hello in hellos}) == 1
    assert len({welcome.session for welcome in heard}) == 1
    client.issues("a", "read 1")
    assert client.ends("a") == "FINISHED DONE 2"


def test_a_welcome_that_does_not_decode_opens_nothing(partner: Partner, client: Client) -> None:
    def broken(welcome: Packet, body: bytes) -> list[Packet]:
        return [replace(welcome, body=body)]

    good = partner.about.pack()
    for body in (b"", good[:-1], good[:20], b"\xff" * 80, good + b"\0"):
        answered(partner, lambda welcome, body=body: broken(welcome, body))
        why = not_opened(partner, client)
        assert "welcome does not decode" in why, body[:20]
    answered(partner, lambda welcome: [replace(welcome, session=0)])
    partner.mouth = lambda session, packet: [replace(packet, session=0)]
    assert "welcome does not decode" in not_opened(partner, client)


def test_an_operation_that_means_something_else_is_not_called(
    partner: Partner, client: Client
) -> None:
    hashes = dict(partner.about.operations)
    hashes[code("read")] ^= 1
    del hashes[code("mirror")]
    partner.about = replace(partner.about, hash=partner.about.hash ^ 1, operations=hashes)
    client.opens(partner.name)
    client.issues("a", "read 1")
    refused = client.ends("a")
    assert refused.startswith("CONNECTION_FAILED REFUSED") and "'read'" in refused
    assert "gidl breaking" in refused
    client.issues("b", "level")
    partner.task("level").done(bytes(8))
    assert client.ends("b").startswith("FINISHED DONE 0")
    del partner.operations[code("mirror")]
    client.issues("c", "mirror 10")
    assert client.ends("c").startswith("COMMAND_FAILED UNKNOWN_OPERATION")
    assert {call.code for call in partner.packets(Kind.CALL)} == {code("level"), code("mirror")}


def test_more_calls_than_there_are_credits_are_not_sent(partner: Partner, client: Client) -> None:
    answered(
        partner,
        lambda welcome: [replace(welcome, body=replace(partner.about, credits=2).pack())],
    )
    client.opens(partner.name)
    client.issues("a", "exchange")
    client.issues("b", "exchange")
    client.issues("c", "exchange")
    full = client.ends("c")
    assert full.startswith("COMMAND_FAILED QUEUE_FULL") and "2 calls are unanswered" in full
    partner.task("exchange", 1).fail(Detail.REJECTED, "no")
    client.ends("b")
    client.issues("d", "read 1")
    assert client.ends("d") == "FINISHED DONE 2"
    assert {call.counter for call in partner.packets(Kind.CALL)} == {1, 2, 3}


def test_a_first_is_repeated_as_it_is_until_a_second_comes(
    partner: Partner, client: Client
) -> None:
    firsts: list[bytes] = []

    def hold_back(sent: bytes) -> list[bytes]:
        header = Header.of(sent)
        assert header is not None
        if header.kind != Datagram.SECOND:
            return [sent]
        firsts.append(sent)
        return [sent] if len(firsts) == 4 else []

    partner.listener.line = Through(hold_back)
    client.opens(partner.name)
    assert len(firsts) == 4 and len(set(firsts)) == 1  # the same Second to the same First
    assert len(firsts[0]) == HEADER + 48
    assert len(partner.sessions) == 1
    client.issues("a", "read 1")
    assert client.ends("a") == "FINISHED DONE 2"
