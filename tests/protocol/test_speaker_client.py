"""The speaker as client: of our broker, and of a C++ server."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import pytest
from hall import laboratory_of, start_broker
from processes import Laboratory
from speaker import broker, packets
from speaker.client import Call, Session
from speaker.frames import HEADER, Inner
from speaker.lcm import BROKER_PLACE, Loop
from speaker.noise import Keys
from speaker.packets import Detail, Failure, Packet, Progress, Reader, Status, code_of

MEASURE = code_of("robcl::LaserDistanceSensor::measure")
BEAM = code_of("robcl::LaserDistanceSensor::beam")
POWER = code_of("robcl::LaserDistanceSensor::power")
TRAVEL = code_of("lab::RailSensor::travel")
RAIL_END = packets.f64(1.0)

Open = Callable[[str, str], Session]


@pytest.fixture
def connect(loop: Loop, keys: Keys) -> Open:
    return lambda address, interface: Session(loop, address, keys, interface)


@pytest.fixture
def rail(lab: Laboratory, connect: Open) -> Session:
    """A session with RAIL, which stands at the start of its way, and whose name is settled."""
    lab.start(lab.build / "tests/system/rail/rail_server", ready="serving RAIL")
    session = connect(address_of_rail(connect), "lab::RailSensor")
    session.ready()
    session.loop.until(lambda: registration(session) == "confirmed", "the name is settled")
    return session


def address_of_rail(connect: Open) -> str:
    office = connect(BROKER_PLACE, "gecos::Broker")
    office.ready()
    entry = broker.lookup(office, "RAIL")
    office.end()
    office.close()
    return entry.lcm_address


def distance(reply: Packet) -> float:
    assert reply.detail == Detail.DONE, Failure.of(reply.body)
    r = Reader(reply.body)
    value, valid = r.f64(), r.boolean()
    assert valid and len(r.rest()) == 24
    return value


def describe(session: Session) -> tuple[str, str, int, str]:
    """Name, interface, commands that wait, operation that runs."""
    reply = session.call(packets.DESCRIBE)
    assert reply.detail == Detail.DONE
    r = Reader(reply.body).block()
    name, interface, _ = r.string(), r.string(), r.string()
    assert r.u64() != 0 and r.boolean()
    r.string(), r.string(), r.u64()
    return name, interface, r.u32(), r.string()


def registration(session: Session) -> str:
    r = Reader(session.call(packets.DESCRIBE).body).block()
    r.string(), r.string(), r.string(), r.u64(), r.boolean()
    r.string(), r.string(), r.u64(), r.u32(), r.string(), r.u32()
    return r.string()


def test_the_broker_welcomes_lists_and_looks_up(connect: Open, lab: Laboratory) -> None:
    office = connect(BROKER_PLACE, "gecos::Broker")
    welcome = office.ready()
    assert (welcome.name, welcome.interface) == ("BROKER", "gecos::Broker")
    assert {code_of(f"gecos::Broker::{name}") for name in ("enlist", "lookup", "list")} <= set(
        welcome.operations
    )
    reply = office.call(code_of("gecos::Broker::lookup"), packets.string("NOBODY"))
    failure = Failure.of(reply.body)
    assert (reply.detail, failure.exception) == (Detail.FAULT, "gecos::UnknownName")
    assert Reader(failure.value).string() == "NOBODY"
    assert office.end().session == office.id


def test_a_young_broker_gives_a_name_to_the_object_that_was_served_first(
    users: tuple[Keys, Keys], connect: Open
) -> None:
    def arm(office: Session) -> broker.Entry:
        boot = office.hello.boot
        return broker.Entry("ARM", "Arm", [], 0, boot, 1, "eva", "", f"host {boot}", [], True)

    with laboratory_of(users[1]) as lab:
        start_broker(lab)
        began = time.monotonic()
        fresh, old = (connect(BROKER_PLACE, "gecos::Broker") for _ in range(2))
        fresh.ready(), old.ready()
        left = broker.enlist(fresh, arm(fresh))
        assert left is None or 0 < left <= 1
        assert left is not None or time.monotonic() > began + 1, "it is not a second old"
        if left is not None and time.monotonic() < began + 0.9:
            assert broker.enlist(old, arm(old), served_for=5.0) is not None
            assert broker.lookup(fresh, "ARM") == arm(old)
            taken = Failure.of(fresh.call(broker.ENLIST, arm(fresh).pack()).body)
            assert taken.exception == "gecos::NameTaken"
            assert f"host {old.hello.boot}" in Reader(taken.value[8:]).string()
        for office in fresh, old:
            office.end()
            office.close()


def test_a_large_packet_goes_and_comes_in_pieces(connect: Open, lab: Laboratory) -> None:
    office = connect(BROKER_PLACE, "gecos::Broker")
    office.ready()
    name = "".join(f"{i:07}-" for i in range(30_000))
    reply = office.call(code_of("gecos::Broker::withdraw"), packets.string(name))
    failure = Failure.of(reply.body)
    assert failure.exception == "gecos::UnknownName", failure.text[:200]
    assert Reader(failure.value).string() == name


def test_an_interface_that_the_object_has_not_is_refused(connect: Open, lab: Laboratory) -> None:
    office = connect(BROKER_PLACE, "lab::RailSensor")
    office.loop.until(lambda: office.refused is not None, "Refused")
    assert office.refused is not None and "gecos::Broker" in office.refused.text


def test_a_sensor_call_is_answered_and_described(rail: Session) -> None:
    assert distance(rail.call(MEASURE)) == 2.0
    assert describe(rail) == ("RAIL", "lab::RailSensor", 0, "")
    assert rail.call(packets.PING).detail == Detail.DONE
    assert rail.end().session == rail.id


def test_what_moves_needs_a_status_and_reports(rail: Session) -> None:
    assert rail.call(TRAVEL, RAIL_END).detail == Detail.DENIED
    assert distance(rail.call(MEASURE)) == 2.0
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, packets.f64(0.3))
    rail.loop.until(lambda: bool(ride.progress), "progress")
    assert rail.finish(ride).detail == Detail.DONE
    assert distance(rail.call(MEASURE)) == 2.0 - 0.3
    told = [Progress.of(p.body) for p in ride.progress if p.detail == Detail.EXECUTING]
    assert any(0.0 < progress.fraction < 1.0 for progress in told)
    assert [p.fraction for p in told] == sorted(p.fraction for p in told)


def test_a_declared_exception_arrives(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    reply = rail.call(TRAVEL, packets.f64(10.0))
    failure = Failure.of(reply.body)
    assert (reply.detail, failure.exception) == (Detail.FAULT, "lab::RailEnd")
    assert failure.value == packets.f64(1.0)


def executing(call: Call) -> bool:
    return any(packet.detail == Detail.EXECUTING for packet in call.progress)


def moved(call: Call) -> bool:
    return any(Progress.of(packet.body).fraction > 0.0 for packet in call.progress)


def test_cancel_ends_the_ride_and_what_was_queued_after_it(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, RAIL_END)
    rail.loop.until(lambda: moved(ride), "the ride")
    back = rail.start(TRAVEL, packets.f64(0.0))
    rail.loop.until(lambda: bool(back.progress), "its place in the queue")
    assert back.progress[0].detail == Detail.QUEUED
    rail.cancel(ride)
    assert rail.finish(ride).detail == Detail.CANCELED
    assert rail.finish(back).detail == Detail.CANCELED
    assert 1.0 < distance(rail.call(MEASURE)) < 2.0


def test_stop_ends_what_runs_and_gives_a_new_epoch(rail: Session) -> None:
    before = rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, RAIL_END)
    rail.loop.until(lambda: executing(ride), "the ride")
    stopped = rail.call(packets.STOP)
    assert stopped.detail == Detail.DONE
    assert rail.finish(ride).detail == Detail.STOPPED
    assert stopped.epoch not in (0, before)
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.STOPPED
    rail.epoch = stopped.epoch
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DONE


def test_a_take_over_preempts_the_others_and_tells_them_the_newer_epoch(
    rail: Session, connect: Open
) -> None:
    guard = connect(address_of_rail(connect), "lab::RailSensor")
    guard.ready()
    before = rail.acquire(Status.ACTOR, "two hands")
    assert guard.acquire(Status.ACTOR, "two hands") == before
    ride = rail.start(TRAVEL, RAIL_END)
    rail.loop.until(lambda: executing(ride), "the ride")
    taken = guard.call(packets.TAKE_OVER)
    assert taken.detail == Detail.DONE and taken.epoch not in (0, before)
    preempted = rail.finish(ride)
    assert preempted.detail == Detail.PREEMPTED and preempted.epoch == taken.epoch

    late = rail.call(POWER, packets.boolean(True))  # under the epoch from before
    assert late.detail == Detail.PREEMPTED
    rail.epoch = taken.epoch
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DENIED
    second = Failure.of(rail.call(packets.TAKE_OVER).body)
    assert second.exception == "gecos::StatusRefused" and "has taken over" in second.text
    assert guard.call(POWER, packets.boolean(True)).detail == Detail.DONE  # its own older epoch

    assert guard.call(packets.GIVE_BACK).detail == Detail.DONE
    rail.epoch = before
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.PREEMPTED
    rail.epoch = taken.epoch
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DONE
    guard.end()
    guard.close()


def test_a_released_status_is_gone(rail: Session) -> None:
    epoch = rail.acquire(Status.ACTOR)
    held = Reader(rail.call(packets.HOLDERS).body)
    assert held.u32() == 1
    holder = held.block()
    assert holder.u32() == Status.ACTOR and holder.string() == "speaker"
    released = rail.call(packets.RELEASE, packets.u64(epoch) + packets.boolean(False))
    assert released.detail == Detail.DONE
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.LEASE_LOST
    rail.epoch = 0
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DENIED


def test_nonsense_is_answered_as_the_protocol_says(rail: Session) -> None:
    assert rail.call(code_of("lab::RailSensor::fly")).detail == Detail.UNKNOWN_OPERATION
    assert rail.call(200).detail == Detail.UNKNOWN_OPERATION
    rail.acquire(Status.ACTOR)
    assert rail.call(TRAVEL, b"\0\0\0").detail == Detail.BAD_PARAMETER
    assert rail.call(POWER, b"\x02").detail == Detail.BAD_PARAMETER
    assert rail.call(packets.ACQUIRE, packets.u32(0)).detail == Detail.BAD_PARAMETER


def test_a_call_far_ahead_has_not_arrived_and_is_not_answered(rail: Session) -> None:
    rail.send(Packet(packets.Kind.CALL, code=MEASURE, counter=2000))
    assert distance(rail.call(MEASURE)) == 2.0, "it was sent later and is answered"
    assert not replies_of(rail, 2000)


def await_packet(session: Session, kind: packets.Kind, counter: int) -> Packet:
    def those() -> list[Packet]:
        return [p for p in session.received if (p.kind, p.counter) == (kind, counter)]

    session.loop.until(lambda: bool(those()), f"{kind.name} of {counter}")
    return those()[-1]


def replies_of(session: Session, counter: int) -> list[Packet]:
    return [p for p in session.received if (p.kind, p.counter) == (packets.Kind.REPLY, counter)]


def test_a_repeated_call_is_executed_once_and_answered_by_the_same_bytes(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    rail.acknowledges = False
    dark = rail.start(POWER, packets.boolean(False))
    assert rail.finish(dark).detail == Detail.DONE
    assert rail.call(MEASURE).detail == Detail.FAULT  # the laser is off
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DONE
    counter = dark.packet.counter
    rail.send(dark.packet)
    rail.send(Packet(packets.Kind.QUERY, counter=counter))
    rail.loop.until(lambda: len(replies_of(rail, counter)) >= 3, "the reply, three times")
    assert len({reply.pack() for reply in replies_of(rail, counter)}) == 1
    assert distance(rail.call(MEASURE)) == 2.0  # not switched off again


def test_what_is_acknowledged_is_answered_no_more(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    dark = rail.start(POWER, packets.boolean(False))
    rail.finish(dark)
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DONE  # acknowledges `dark`
    before = len(replies_of(rail, dark.packet.counter))
    rail.send(dark.packet)
    rail.send(Packet(packets.Kind.QUERY, counter=dark.packet.counter))
    assert distance(rail.call(MEASURE)) == 2.0
    assert len(replies_of(rail, dark.packet.counter)) == before


def test_a_query_while_it_runs_is_answered_by_progress(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, RAIL_END)
    rail.loop.until(lambda: executing(ride), "the ride")
    for _ in range(5):  # repeated, it does not stand in the queue again
        rail.send(ride.packet)
    *_, waiting, operation = describe(rail)
    assert waiting == 0 and operation.endswith("travel")
    rail.cancel(ride)
    assert rail.finish(ride).detail == Detail.CANCELED


def test_forged_repeated_and_clear_datagrams_change_nothing(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    assert distance(rail.call(MEASURE)) == 2.0
    sealed = rail.connection.sealed
    assert sealed is not None

    def off(counter: int, spare: int) -> bytes:
        """A call that would switch the laser off."""
        packet = Packet(packets.Kind.CALL, code=POWER, session=rail.id, counter=counter)
        packet = replace(packet, epoch=rail.epoch, body=packets.boolean(False))
        return sealed.seal(Inner.PACKET, spare, packet.pack())

    number = rail.count()
    rail.acknowledges = False  # a call up to there is still to come
    good = off(number, 50)
    for at in (*range(len(good) - 20, len(good)), HEADER + 3, HEADER + 9, 8, 7):
        bad = bytearray(good)
        bad[at] ^= 1
        rail.connection.publish(bytes(bad))
    for size in range(len(good)):
        rail.connection.publish(good[:size])
    clear = Packet(
        packets.Kind.CALL, code=POWER, session=rail.id, counter=number + 1, epoch=rail.epoch
    )
    rail.connection.publish(replace(clear, body=packets.boolean(False)).pack())
    rail.connection.publish(good[:HEADER] + clear.pack())
    rail.connection.publish(bytes(4) + good[4:])
    assert distance(rail.call(MEASURE)) == 2.0

    rail.connection.publish(good)  # as it is, it counts: the forgeries were near enough
    assert await_packet(rail, packets.Kind.REPLY, number).detail == Detail.DONE
    assert rail.call(MEASURE).detail == Detail.FAULT
    assert rail.call(POWER, packets.boolean(True)).detail == Detail.DONE
    rail.connection.publish(good)  # replayed, not even answered
    assert distance(rail.call(MEASURE)) == 2.0
    assert len(replies_of(rail, number)) == 1


def test_keys_of_up_to_eight_generations_ahead_are_taken(rail: Session) -> None:
    sealed = rail.connection.sealed
    assert sealed is not None
    for ahead in (1, 8):
        for _ in range(ahead):
            sealed.channel.sealer.turn_over()
        assert distance(rail.call(MEASURE)) == 2.0


def test_a_deadline_that_passes_while_it_waits_or_runs_ends_the_command(rail: Session) -> None:
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, RAIL_END, deadline_s=0.4)
    rail.loop.until(lambda: executing(ride), "the ride")
    late = rail.start(TRAVEL, packets.f64(0.0), deadline_s=0.05)
    assert rail.finish(late).detail == Detail.EXPIRED
    assert rail.finish(ride).detail == Detail.TIMED_OUT


def test_a_stream_is_shared_opened_and_signed(rail: Session) -> None:
    reply = rail.call(packets.SUBSCRIBE, packets.u32(BEAM))
    assert reply.detail == Detail.DONE
    stream = Reader(reply.body).u32()
    rail.loop.until(lambda: stream in rail.shares, "Share")
    reader = rail.shares[stream]
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, packets.f64(0.2))
    seen: list[tuple[int, float]] = []

    def enough() -> bool:
        while reader.samples:
            sample = reader.samples.popleft()
            seen.append((sample.sequence, Reader(sample.value).f64()))
        return len(seen) >= 5 and ride.over

    rail.loop.until(enough, "samples")
    assert seen == sorted(seen, key=lambda one: (one[0], -one[1]))
    assert [value for _, value in seen] == sorted((value for _, value in seen), reverse=True)
    assert reader.share.largest == 33 + 8 and reader.share.keep > 0
    assert rail.call(packets.UNSUBSCRIBE, packets.u32(BEAM)).detail == Detail.DONE
    assert rail.call(packets.SUBSCRIBE, packets.u32(MEASURE)).detail == Detail.UNKNOWN_OPERATION

    bad = bytearray(reader.last)
    bad[-1] ^= 1
    dropped = reader.dropped
    reader.heard(bytes(bad))
    reader.heard(reader.last)
    assert reader.dropped == dropped + 2


def test_silence_takes_the_status_and_then_the_session(rail: Session, connect: Open) -> None:
    rail.acquire(Status.ACTOR)
    other = connect(f"{rail.connection.place}#{rail.connection.server.hex()}", "lab::RailSensor")
    other.ready()
    refused = other.call(packets.ACQUIRE, packets.u32(Status.ACTOR))
    failure = Failure.of(refused.body)
    assert (refused.detail, failure.exception) == (Detail.FAULT, "gecos::StatusRefused")
    rail.loop.leave(rail.connection)  # falls silent

    def taken() -> bool:
        return Reader(other.call(packets.HOLDERS).body).u32() == 0

    other.loop.until(taken, "the end of the status of who is silent", patience=5 * 0.5)
    other.acquire(Status.ACTOR)


def test_a_session_that_the_server_does_not_know_is_told_goodbye(rail: Session) -> None:
    rail.end()
    rail.goodbye = None
    rail.id += 7000
    rail.send(Packet(packets.Kind.CALL, code=MEASURE, counter=1))
    rail.loop.until(lambda: rail.goodbye is not None, "Goodbye")
    assert rail.goodbye is not None and rail.goodbye.session == rail.id


def test_who_is_not_admitted_gets_no_channel(rail: Session, loop: Loop, keys: Keys) -> None:
    address = f"{rail.connection.place}#{rail.connection.server.hex()}"
    stranger = Session(loop, address, Keys(b"\x07" * 32, keys.admitted), "lab::RailSensor")
    loop.for_seconds(0.3)
    assert stranger.connection.sealed is None
    assert distance(rail.call(MEASURE)) == 2.0
