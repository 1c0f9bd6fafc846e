"""A client that was written from docs/protocol.md alone speaks to a server of ours over lcm."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path

import gecos
import pytest
from gecos_idl.broker import Broker
from lamp import Lamp, PlainLamp
from protocol_speaker import (
    DONE,
    FAULT,
    REFUSED,
    WELCOME,
    Channel,
    Session,
    function_code,
    take_text,
    text,
)

PING, DESCRIBE, ACQUIRE, RELEASE = 3, 4, 5, 6
SHINE, DIM, LABEL = 0x1001, 0x1003, 0x1005
ACTOR = 1
BAD_PARAMETER, UNKNOWN_OPERATION, DENIED = 7, 8, 9


@pytest.fixture
def channel(lab: gecos.Lab, server: gecos.Server) -> Iterator[Channel]:
    (entry,) = [one for one in lab.broker(Broker).list().result() if one.name == "LAMP"]
    (address,) = [one for one in entry.addresses if one.startswith("lcm:")]
    channel = Channel(address, Path(os.environ["GECOS_KEY_DIR"]))
    yield channel
    channel.close()


@pytest.fixture
def session(channel: Channel) -> Session:
    session = Session(channel, "test::Lamp")
    assert session.opened.kind == WELCOME
    return session


def acquire(session: Session) -> None:
    granted = session.call(ACQUIRE, struct.pack(">i", ACTOR))
    assert granted.flags == DONE
    size, status, session.epoch = struct.unpack(">iiQ", granted.body)
    assert (size, status) == (12, ACTOR)


def test_a_session_is_opened_and_says_what_the_object_is(session: Session) -> None:
    name, at = take_text(session.opened.body, 0)
    interface, _ = take_text(session.opened.body, at)
    assert (name, interface) == ("LAMP", "test::Lamp")
    assert session.call(PING).body == b""
    about = session.call(DESCRIBE).body
    assert take_text(about, 4)[0] == "LAMP"


def test_an_interface_that_the_object_does_not_have_is_refused(channel: Channel) -> None:
    refused = Session(channel, "robcl::Rx90").opened
    assert (refused.kind, refused.flags) == (REFUSED, 23)
    assert "LAMP is a test::Lamp, not a robcl::Rx90" in take_text(refused.body, 0)[0]


def test_status_is_needed_acquired_and_given_back(session: Session) -> None:
    dim = struct.pack(">d", 4.0)
    assert session.call(DIM, dim).flags == DENIED
    acquire(session)
    assert session.call(DIM, dim).flags == DONE
    assert session.call(RELEASE, struct.pack(">Q?", session.epoch, False)).flags == DONE
    session.epoch = 0
    assert session.call(DIM, dim).flags == DENIED


def test_a_call_that_is_repeated_runs_once(session: Session, servant: PlainLamp) -> None:
    acquire(session)
    servant.value = 8.0
    reply = session.call(DIM, struct.pack(">d", 2.0), times=5)
    assert (reply.flags, reply.body) == (DONE, struct.pack(">d", 4.0))
    assert servant.starts == ["dim"]


def test_what_is_wrong_is_said(session: Session) -> None:
    assert session.call(0x1999).flags == UNKNOWN_OPERATION
    acquire(session)
    assert session.call(DIM, b"\1").flags == BAD_PARAMETER


def test_a_declared_exception_travels(session: Session) -> None:
    acquire(session)
    burnt = session.call(SHINE, struct.pack(">d", 300.0))
    assert burnt.flags == FAULT
    name, at = take_text(burnt.body, take_text(burnt.body, 0)[1])
    assert (name, burnt.body[at:]) == ("test::Burnt", struct.pack(">i", 300))


def test_who_holds_the_lamp_is_in_the_refusal(lamp: Lamp, session: Session) -> None:
    with gecos.actor(lamp):
        refused = session.call(ACQUIRE, struct.pack(">i", ACTOR))
    assert refused.flags == FAULT
    name, at = take_text(refused.body, take_text(refused.body, 0)[1])
    assert name == "gecos::StatusRefused"
    reason, at = take_text(refused.body, at)
    assert reason.startswith("LAMP: ")
    count, _, status = struct.unpack_from(">iii", refused.body, at)
    assert (count, status) == (1, ACTOR)


@pytest.mark.parametrize("loss", [0, 5])
def test_a_large_answer_comes_in_pieces(
    channel: Channel, session: Session, servant: PlainLamp, loss: int
) -> None:
    large = "".join(f"{number:06}" for number in range(50_000))
    servant.label = lambda: large
    channel.loss = loss
    assert session.call(LABEL).body == text(large)


def test_a_large_call_goes_in_pieces(session: Session) -> None:
    acquire(session)
    # What is behind the parameters is skipped: a newer client's.
    assert session.call(DIM, struct.pack(">d", 2.0) + bytes(300_000)).flags == DONE


def test_goodbye_is_answered(session: Session) -> None:
    session.call(PING)
    assert take_text(session.close().body, 0)[0] == "as you asked"


def test_function_codes_are_hashes_of_names() -> None:
    assert function_code("gecos::Broker::lookup") == 0x49E3D3E3
