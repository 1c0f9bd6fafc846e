"""The speaker as server: our clients call it."""

from __future__ import annotations

import pytest
import values
from hall import Hall
from partner import Partner, code, step
from speaker.client import Session
from speaker.packets import Detail, Failure, Kind, Packet, Status, string, u32
from told import Client


def test_a_client_greets_calls_and_takes_leave(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    hello = partner.session.hello
    assert hello is not None and hello.interface == "speaking::Partner"
    assert (hello.hash, hello.oldest_ns) == (partner.about.hash, 750_000_000)
    client.issues("a", "read 41")
    assert client.ends("a") == "FINISHED DONE 42"
    client.issues("b", "describe")
    assert client.ends("b") == f"FINISHED DONE {partner.name}"
    client.issues("c", "ping")
    assert client.ends("c") == "FINISHED DONE -"
    client.tell("close")
    client.says("closed")
    partner.loop.until(lambda: partner.session.over, "its leave")
    assert partner.session.goodbyes or partner.session.visitor.bye
    assert [call.counter for call in partner.packets(Kind.CALL)] == [1, 2, 3]


def test_values_of_every_kind_go_both_ways(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    said = values.things() + string("ping")
    for nth, given in enumerate([values.other_things(), values.things(), values.other_things()]):
        client.issues("a", "exchange")
        task = partner.task("exchange", nth)
        assert task.parameters == said
        task.done(given + string(f"pong {nth}") + u32(2**32 - 1))
        assert client.ends("a") == f"FINISHED DONE pong {nth} 4294967295"
        said = given + string("ping")


@pytest.mark.parametrize(
    ("given", "means"),
    [
        (values.things_of_the_future(), values.other_things()),
        (values.things_of_the_past(), values.other_things()[:-4] + u32(3)),
    ],
    ids=["future", "past"],
)
def test_an_appendable_struct_of_another_time_is_read(
    given: bytes, means: bytes, partner: Partner, client: Client
) -> None:
    client.opens(partner.name)
    client.issues("a", "exchange")
    partner.task("exchange").done(given + string("") + u32(0) + b"a parameter of the future")
    assert client.ends("a").startswith("FINISHED DONE")
    client.issues("b", "exchange")
    second = partner.task("exchange", 1)
    assert second.parameters == means + string("ping")
    second.done(given + string("") + u32(0))
    client.ends("b")


@pytest.mark.parametrize("size", [0, 8_100, 8_192, 300_000])
def test_large_bodies_go_both_ways_in_pieces(size: int, partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.issues("a", f"mirror {size}")
    assert client.ends("a") == "FINISHED DONE right"


def test_a_declared_exception_keeps_its_members(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.acquires()
    client.issues("a", "walk 5")
    value = u32(3) + string("a wall")
    partner.task("walk").fail(Detail.FAULT, "stuck", "speaking::Stuck", value)
    assert client.ends("a") == "COMMAND_FAILED FAULT Stuck 3 a wall"


FAILED = [
    "REJECTED",
    "BAD_PARAMETER",
    "UNKNOWN_OPERATION",
    "DENIED",
    "QUEUE_FULL",
    "EXPIRED",
    "TIMED_OUT",
    "FAULT",
    "CANCELED",
    "PREEMPTED",
    "STOPPED",
    "LEASE_LOST",
    "PRESENCE_LOST",
    "OUTCOME_UNKNOWN",
]


def test_each_way_to_fail_arrives_with_its_text(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    for nth, detail in enumerate([*FAILED, "NOT_STARTED"]):
        client.issues("a", "exchange")
        partner.task("exchange", nth).fail(Detail[detail], f"because of {nth}")
        state = "CONNECTION_FAILED" if detail == "NOT_STARTED" else "COMMAND_FAILED"
        assert client.ends("a") == f"{state} {detail} because of {nth}"


def test_a_detail_that_no_server_sends_is_a_fault(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    for nth, detail in enumerate([0, 1, 2, 3, 4, 19, 22, 23, 24, 25, 127, 128, 255]):
        client.issues("a", "exchange")
        task = partner.task("exchange", nth)
        body = Failure("who knows").pack()
        task.reply(Packet(Kind.REPLY, detail, body=body))
        assert client.ends("a") == "COMMAND_FAILED FAULT who knows", detail


def test_a_walk_waits_runs_and_tells_where_it_is(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.acquires()
    client.issues("first", "walk 2")
    client.issues("second", "walk 3")
    first, second = partner.task("walk"), partner.task("walk", 1)
    client.stands("first", "EXECUTING 0 0")
    client.stands("second", "QUEUED 1 0")
    first.progress(0.5, step(1, "door"))
    client.stands("first", "EXECUTING 0 0.5 1 door")
    first.done(u32(2))
    assert client.ends("first") == "FINISHED DONE 2"
    client.stands("second", "EXECUTING 0 0")
    second.progress(0.25)
    client.stands("second", "EXECUTING 0 0.25")
    second.done(u32(3))
    assert client.ends("second") == "FINISHED DONE 3"


def test_cancel_ends_what_waits_and_asks_what_runs(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.acquires()
    for tag in ("runs", "waits", "last"):
        client.issues(tag, "walk 2")
    partner.task("walk", 2)
    client.tell("cancel waits")
    assert client.ends("waits").startswith("COMMAND_FAILED CANCELED")
    client.tell("cancel runs")
    client.stands("runs", "CANCELING")
    assert client.ends("last").startswith("COMMAND_FAILED CANCELED")
    partner.task("walk").fail(Detail.CANCELED, "after one step")
    assert client.ends("runs") == "COMMAND_FAILED CANCELED after one step"


def test_what_runs_to_its_end_although_it_was_canceled_is_done(
    partner: Partner, client: Client
) -> None:
    client.opens(partner.name)
    client.acquires()
    client.issues("a", "walk 2")
    client.stands("a", "EXECUTING")
    client.tell("cancel a")
    client.stands("a", "CANCELING")
    partner.task("walk").done(u32(2))
    assert client.ends("a") == "FINISHED DONE 2"


def test_a_deadline_travels_and_shrinks(partner: Partner, client: Client) -> None:
    partner.mouth = lambda session, packet: [] if packet.kind == Kind.PROGRESS else [packet]
    client.opens(partner.name)
    client.tell("deadline 0.5")
    client.issues("a", "exchange")
    task = partner.task("exchange")
    calls = partner.awaits(Kind.CALL, 3)
    left = [call.deadline_ns for call in calls]
    assert left == sorted(left, reverse=True) and left[0] > left[-1]
    assert all(0 < ns <= 500_000_000 for ns in left)
    assert {call.body for call in calls} == {task.parameters}
    assert client.ends("a").startswith("COMMAND_FAILED TIMED_OUT")


def test_a_call_carries_the_epoch_of_its_status(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.issues("early", "mark 1")
    assert client.ends("early").startswith("COMMAND_FAILED DENIED")
    epoch = client.acquires()
    client.issues("a", "mark 1")
    assert client.ends("a") == "FINISHED DONE 2"
    client.issues("s", "stop")
    assert client.ends("s") == "FINISHED DONE -"
    renewed = partner.session.epoch
    assert renewed not in (0, epoch)
    client.issues("b", "mark 2")
    assert client.ends("b") == "FINISHED DONE 3"
    marks = [call.epoch for call in partner.packets(Kind.CALL) if call.code == code("mark")]
    assert set(marks) == {0, epoch, renewed} and marks[0] == 0
    client.tell("release")
    client.says("released")
    client.issues("late", "mark 3")
    assert client.ends("late").startswith("COMMAND_FAILED DENIED")


def test_a_status_that_another_one_has_is_refused_and_says_who(
    partner: Partner, client: Client, hall: Hall
) -> None:
    other = Session(partner.loop, partner.listener.address, hall.keys, "speaking::Partner")
    other.ready()
    other.acquire(Status.ACTOR)
    client.opens(partner.name)
    client.tell("acquire")
    refused = client.says("not acquired:")
    assert partner.name in refused
    other.end()
    other.close()
    assert client.acquires() > 0


def test_stop_ends_what_runs_and_what_waits(partner: Partner, client: Client) -> None:
    client.opens(partner.name)
    client.acquires()
    client.issues("runs", "walk 2")
    client.issues("waits", "walk 2")
    partner.task("walk", 1)
    client.issues("s", "stop")
    assert client.ends("s").startswith("FINISHED")
    assert client.ends("runs").startswith("COMMAND_FAILED STOPPED")
    assert client.ends("waits").startswith("COMMAND_FAILED STOPPED")
    assert not partner.task("walk", 1).feedback  # it never ran


def test_what_became_of_a_command_can_be_asked_in_another_session(
    partner: Partner, client: Client
) -> None:
    client.opens(partner.name)
    client.acquires()
    client.issues("a", "mark 1")
    client.ends("a")
    client.tell("name a")
    name = client.says("a is")
    boot, session, counter = (int(part, 16) for part in name.split("-"))
    assert (boot, session) == (partner.about.boot, partner.session.id)
    client.opens(partner.name)
    assert partner.session.id != session
    client.issues("b", f"outcome {name}")
    assert client.ends("b") == "FINISHED DONE DONE"
    client.issues("c", f"outcome {boot:x}-{session:x}-{counter + 1:x}")
    assert client.ends("c") == "FINISHED DONE NOT_STARTED"
