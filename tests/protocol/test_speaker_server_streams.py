"""The speaker as server of a stream: our clients open it, and believe nobody else."""

from __future__ import annotations

from dataclasses import replace

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from partner import Partner, code
from speaker.frames import Inner
from speaker.packets import SUBSCRIBE, Kind, f64
from speaker.streams import StreamWriter, seal
from told import Client


def follows(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.tell("follow")
    client.says("follows")


def test_samples_come_with_their_numbers(partner: Partner, client: Client) -> None:
    partner.level.seal(f64(0.5))  # before anybody came: sent again to who opens the stream
    follows(partner, client)
    assert client.says("sample") == "1 0 0.5"
    for number in range(2, 5):
        partner.level.publish(partner.level.seal(f64(number / 4)))
        assert client.says("sample") == f"{number} 0 {number / 4:g}"
    partner.level.publish(partner.level.seal(f64(8.0), skip=6))
    assert client.says("sample") == "11 6 8"
    assert all(opened for _, opened in partner.session.shares.values())


def test_a_share_is_repeated_until_it_is_opened(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    shares = 0

    def only_the_third(number: int, body: bytes) -> bool:
        nonlocal shares
        shares += 1
        return shares == 3

    partner.session.passes_share = only_the_third
    client.tell("follow")
    client.says("follows")
    assert shares == 3
    partner.loop.until(
        lambda: all(opened for _, opened in partner.session.shares.values()), "Opened"
    )
    partner.level.publish(partner.level.seal(f64(1.0)))
    assert client.says("sample") == "1 0 1"


def test_a_sample_that_is_forged_old_or_cut_is_not_read(partner: Partner, client: Client) -> None:
    follows(partner, client)
    level = partner.level
    old = level.seal(f64(1.0))
    good = level.seal(f64(2.0))
    for at in range(len(good)):
        level.publish(good[:at] + bytes([good[at] ^ 0x10]) + good[at + 1 :])
    for size in range(0, len(good), 7):
        level.publish(good[:size])
    reader = Ed25519PrivateKey.generate()  # who may read has the stream's key, not the server's
    level.publish(seal(level.share(1), reader, 9, f64(66.0)))
    level.publish(good)
    assert client.says("sample") == "2 0 2"
    level.publish(old)
    level.publish(good)
    level.publish(level.seal(f64(3.0)))
    assert client.says("sample") == "3 0 3"


def test_a_sample_that_does_not_decode_is_passed_over(partner: Partner, client: Client) -> None:
    follows(partner, client)
    level = partner.level
    level.publish(level.seal(f64(1.0)))
    assert client.says("sample") == "1 0 1"
    level.publish(level.seal(f64(2.0)[:-1]))
    level.publish(level.seal(f64(3.0)))
    assert client.says("sample") == "3 1 3"


def test_another_stream_under_the_same_id_is_the_one_that_is_opened_next(
    partner: Partner, client: Client
) -> None:
    follows(partner, client)
    partner.level.publish(partner.level.seal(f64(1.0)))
    assert client.says("sample") == "1 0 1"
    (number,) = partner.session.shares
    second = partner.streams[code("level")] = StreamWriter(partner.loop.mouth, largest=8 + 8)
    second.seal(f64(2.0))
    partner.session.shares[number] = (second, False)
    client.tell("follow")
    client.says("follows")
    assert client.says("sample") == "1 0 2"


def test_a_share_that_is_invalid_opens_nothing(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    good = partner.level.share(1)
    bad = [
        replace(good, keep=0).pack(),
        replace(good, keep=1025).pack(),
        replace(good, port=0).pack(),
        replace(good, id=2).pack(),
        good.pack()[:-1],
        good.pack() + b"\0",
        b"",
    ]
    told: list[bytes] = []

    def never(number: int, body: bytes) -> bool:
        for body in bad if not told else []:
            partner.session.visitor.sealed.send(Inner.SHARE, 1, body)
        told.append(body)
        return False

    partner.session.passes_share = never
    client.tell("follow")
    assert "could not be opened in time over lcm" in client.says("not followed:")
    assert not any(opened for _, opened in partner.session.shares.values())


def test_a_subscription_that_is_refused_says_why(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    level = dict(partner.streams)
    partner.streams.clear()
    client.tell("follow")
    assert "there is no such stream" in client.says("not followed:")
    partner.streams |= level
    client.tell("follow")
    client.says("follows")
    assert [call.code for call in partner.packets(Kind.CALL)][-1] == SUBSCRIBE


def test_the_stream_ends_with_the_session(partner: Partner, client: Client) -> None:
    follows(partner, client)
    partner.withdraw("it goes home")
    assert client.says("stream").lower().startswith(("lost", "closed"))
    client.issues("a", "mark 1")
    assert client.ends("a").startswith("CONNECTION_FAILED")
