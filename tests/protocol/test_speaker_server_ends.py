"""The speaker as server that falls silent, leaves, or talks nonsense: our commands all end."""

from __future__ import annotations

import math
import time
from dataclasses import replace

from lines import Mute
from partner import Partner
from speaker.listener import Line
from speaker.packets import Detail, Failure, Kind, Packet, Progress, f64, string, u32, u64
from told import Client
from values import other_things

UNREACHABLE_S = 0.3
LOST_S = 1.3
SLACK = 5.0  # a promised bound, with real processes


def waits(partner: Partner, client: Client, tag: str = "a") -> None:
    """A walk that runs."""
    client.acquires()
    client.issues(tag, "walk 1")
    client.stands(tag, "EXECUTING")


def test_a_server_that_is_not_heard_is_unreachable_and_then_lost(
    partner: Partner, client: Client
) -> None:
    client.opens(partner.name)
    client.tell("follow")
    client.says("follows")
    waits(partner, client)
    partner.listener.line = Mute()
    began = time.monotonic()
    client.stands("a", "UNREACHABLE")
    client.issues("late", "mark 1")
    ended = client.ends("a", SLACK * LOST_S)
    assert time.monotonic() - began > UNREACHABLE_S
    assert ended.startswith("COMMAND_FAILED OUTCOME_UNKNOWN")
    assert partner.name in ended and "silent" in ended
    never = client.ends("late")
    assert never.startswith("CONNECTION_FAILED NOT_STARTED") and "never sent" in never
    assert not [task for task in partner.tasks if task.operation.name == "mark"]  # nor was it
    assert client.says("stream").lower().startswith("lost")
    client.issues("after", "mark 1")
    after = client.ends("after")
    assert after.startswith("CONNECTION_FAILED NO_SERVER") and "create a new proxy" in after


def test_a_server_that_is_back_soon_is_asked_what_became_of_it(
    partner: Partner, client: Client
) -> None:
    client.opens(partner.name)
    waits(partner, client)
    partner.listener.line = Mute()
    client.stands("a", "UNREACHABLE")
    partner.task("walk").done(u32(1))  # nobody hears it
    asked = len(partner.packets(Kind.QUERY))
    partner.listener.line = Line()
    assert client.ends("a") == "FINISHED DONE 1"
    assert len(partner.packets(Kind.QUERY)) > asked
    assert len(partner.tasks) == 1


def test_goodbye_of_the_server_ends_what_is_open(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    waits(partner, client)
    partner.withdraw("it goes home")
    ended = client.ends("a")
    assert ended.startswith("COMMAND_FAILED OUTCOME_UNKNOWN") and "it goes home" in ended
    client.issues("b", "mark 1")
    assert client.ends("b").startswith("CONNECTION_FAILED NO_SERVER")


def test_bye_of_the_server_ends_what_is_open(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    waits(partner, client)
    partner.listener.bye()
    ended = client.ends("a")
    assert ended.startswith("COMMAND_FAILED OUTCOME_UNKNOWN") and "closed the session" in ended


def test_a_server_that_forgot_the_session_says_so(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    waits(partner, client)
    partner.session.over = True  # as one that was started anew
    ended = client.ends("a")  # it is asked what became of it, and knows of nothing
    assert ended.startswith("COMMAND_FAILED OUTCOME_UNKNOWN")


def test_what_is_not_kept_any_more_is_unknown(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    waits(partner, client)
    task = partner.task("walk")
    partner.mouth = lambda session, packet: []
    task.done(u32(1))
    partner.session.replies.forget()
    partner.mouth = lambda session, packet: [packet]
    assert client.ends("a").startswith("COMMAND_FAILED OUTCOME_UNKNOWN its answer is not kept")


def test_a_reading_goes_on_in_another_session(partner: Partner, client: Client) -> None:
    partner.answers_by_hand("read")
    client.opens(partner.name)
    client.issues("a", "read 1")
    task = partner.task("read")
    partner.listener.bye()
    partner.loop.until(lambda: len(partner.sessions) == 2, "another session")
    (again,) = {call.pack() for call in partner.awaits(Kind.CALL)}
    before = u64(task.session.id) + u64(task.call.counter)
    assert Packet.of(again).detail == 1 and Packet.of(again).body == before + u32(1)
    task.done(u32(5))
    assert client.ends("a") == "FINISHED DONE 5"
    assert partner.tasks == [task]  # carried out once


def test_a_reading_is_asked_anew_of_a_server_that_was_started_anew(
    partner: Partner, client: Client
) -> None:
    partner.answers_by_hand("read")
    client.opens(partner.name)
    client.issues("a", "read 1")
    partner.task("read")
    partner.about = replace(partner.about, boot=partner.about.boot ^ 1)
    partner.listener.bye()
    anew = partner.task("read", 1)
    assert (anew.call.detail, anew.call.body) == (0, u32(1))
    anew.done(u32(6))
    assert client.ends("a") == "FINISHED DONE 6"


GARBAGE = {
    "nothing": b"",
    "half": other_things()[:40],
    "a count without end": other_things()[:66] + b"\x7f\xff\xff\xff",
    "a negative count": other_things()[:66] + b"\xff\xff\xff\xff",
    "ones": b"\xff" * 200,
    "a boolean of 7": b"\x07" + other_things()[1:] + string("") + u32(0),
    "all but the last parameter": other_things() + string(""),
}


def test_a_result_that_does_not_decode_is_said_to_be_so(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    for nth, (what, body) in enumerate(GARBAGE.items()):
        client.issues("a", "exchange")
        partner.task("exchange", nth).done(body)
        ended = client.ends("a")
        assert ended.startswith("FINISHED DONE") and "does not decode" in ended, what
    client.issues("b", "read 1")
    assert client.ends("b") == "FINISHED DONE 2"


def test_a_failure_that_does_not_decode_is_a_fault(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    long = Failure("x" * 60_000, "").pack()
    bad = [b"", b"\0", u32(2**31 - 1), string("why"), string("why")[:-1] + b"!", long[:-8]]
    not_text = u32(3) + b"\xff\xfe\0" + string("")
    for nth, body in enumerate([*bad, not_text]):
        client.issues("a", "exchange")
        partner.task("exchange", nth).reply(Packet(Kind.REPLY, Detail.REJECTED, body=body))
        ended = client.ends("a")
        assert ended.startswith("COMMAND_FAILED FAULT") and "does not decode" in ended, body[:20]


def test_an_exception_that_is_unknown_or_broken_keeps_its_text(
    partner: Partner, client: Client
) -> None:
    client.opens(partner.name)
    client.acquires()
    for nth, (name, value) in enumerate(
        [("speaking::Stuck", b""), ("speaking::Stuck", b"\0" * 7), ("no::Such", u32(1) * 9)]
    ):
        client.issues("a", "walk 1")
        partner.task("walk", nth).fail(Detail.FAULT, "so it is", name, value)
        ended = client.ends("a")
        assert ended.startswith("COMMAND_FAILED FAULT") and "so it is" in ended, name


def test_progress_that_is_nonsense_changes_nothing(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    waits(partner, client)
    task = partner.task("walk")
    task.progress(0.25)
    client.stands("a", "EXECUTING 0 0.25")
    for detail in (0, 4, 5, 13, 20, 25, 255):
        body = Progress(3, 0.75).pack()
        task.session.send(Packet(Kind.PROGRESS, detail, counter=task.call.counter, body=body))
    for body in (b"", u32(0), u32(0) + b"\0" * 7):
        task.session.send(Packet(Kind.PROGRESS, 2, counter=task.call.counter, body=body))
    client.issues("p", "ping")
    client.ends("p")
    assert client.stands("a", "") == "EXECUTING 0 0.25"
    for fraction, shown in ((7.0, "1"), (-1.0, "0"), (math.inf, "1"), (math.nan, "0")):
        task.progress(fraction)
        assert client.stands("a", f"EXECUTING 0 {shown}") == f"EXECUTING 0 {shown}"
    task.done(u32(1) + f64(0.0))
    assert client.ends("a") == "FINISHED DONE 1"


def test_feedback_that_does_not_decode_hurts_nobody(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    waits(partner, client)
    for feedback in (b"\0", u32(1), u32(1) + u32(2**31 - 1), b"\xff" * 64):
        partner.task("walk").progress(0.5, feedback)
    client.stands("a", "EXECUTING 0 0.5")
    partner.task("walk").done(u32(1))
    assert client.ends("a") == "FINISHED DONE 1"
