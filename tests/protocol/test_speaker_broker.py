"""The speaker as the broker: by it our clients and servers find each other."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hall import laboratory_of
from lines import Through
from partner import Partner
from processes import Laboratory
from speaker.broker import ENLIST, LOOKUP, Entry
from speaker.client import Session
from speaker.frames import Header
from speaker.frames import Kind as Datagram
from speaker.lcm import BROKER_PLACE, Loop
from speaker.noise import Keys, public_of
from speaker.packets import (
    ACQUIRE,
    Detail,
    Failure,
    Reader,
    Status,
    Welcome,
    boolean,
    code_of,
    f64,
    sequence,
    string,
    u32,
)
from speaker.server import Served
from speaker.tasks import Operation, Task
from told import LANGUAGES, Client, client_of

MEASURE = code_of("robcl::LaserDistanceSensor::measure")
TRAVEL = code_of("lab::RailSensor::travel")


class Office(Served):
    """A broker."""

    def __init__(self, loop: Loop, keys: Keys) -> None:
        self.entries: dict[str, Entry] = {}
        self.served_for: list[float] = []
        """What was said with each enlisting."""
        self.settles_in: float | None = None
        self.taken_by = ""
        self.answer = lambda entry: entry.pack()
        what = [("enlist", ENLIST, self._enlist), ("lookup", LOOKUP, self._lookup)]
        about = Welcome("BROKER", "gecos::Broker", [], 0, secrets.randbits(64), 0, {})
        operations = [
            Operation(name, code, 0, Status.SENSOR, handler=handler) for name, code, handler in what
        ]
        super().__init__(loop, keys, about, operations, BROKER_PLACE)

    def _enlist(self, task: Task) -> None:
        parameters = Reader(task.parameters)
        entry = Entry.of(parameters)
        self.served_for.append(parameters.f64())
        if self.taken_by:
            value = string(entry.name) + string(self.taken_by)
            task.fail(Detail.FAULT, "it is taken", "gecos::NameTaken", value)
            return
        self.entries[entry.name] = entry
        left = self.settles_in
        task.done(boolean(left is not None) + (b"" if left is None else f64(left)))

    def _lookup(self, task: Task) -> None:
        name = Reader(task.parameters).string()
        if name in self.entries:
            task.done(self.answer(self.entries[name]))
            return
        value = string(name) + sequence(map(string, sorted(self.entries)))
        task.fail(Detail.FAULT, f"{name} is not known", "gecos::UnknownName", value)


@pytest.fixture
def lab(users: tuple[Keys, Keys], model: Path) -> Iterator[Laboratory]:
    """Without a broker of ours."""
    with laboratory_of(users[1]) as lab:
        paths = str(model / "python"), lab.env.get("PYTHONPATH")
        lab.env["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        lab.env["GECOS_BROKER"] = BROKER_PLACE
        yield lab


@pytest.fixture
def office(loop: Loop, keys: Keys) -> Iterator[Office]:
    office = Office(loop, keys)
    yield office
    office.close()


@pytest.fixture
def partner(loop: Loop, keys: Keys, model: Path, office: Office) -> Iterator[Partner]:
    partner = Partner(loop, keys, model / "model" / "speaking" / "partner.json")
    office.entries[partner.name] = partner.entry("speaker", "nowhere", os.getpid())
    yield partner
    partner.close()


@pytest.fixture(params=LANGUAGES)
def client(lab: Laboratory, loop: Loop, request: pytest.FixtureRequest) -> Iterator[Client]:
    with client_of(lab, request.param, loop) as client:
        yield client


def test_a_client_asks_for_the_brokers_key_and_finds_the_object(
    office: Office, partner: Partner, client: Client
) -> None:
    client.tell("open NOBODY")
    assert "NOBODY" in client.says("not opened:")
    client.opens(partner.name)
    client.issues("a", "read 1")
    assert client.ends("a") == "FINISHED DONE 2"
    assert office.listener.asked >= 1
    assert not partner.listener.asked  # whose address has its key

    def broken(entry: Entry) -> bytes:
        return entry.pack()[:-3]

    office.answer = broken
    client.tell(f"open {partner.name}")
    assert "does not decode" in client.says("not opened:")
    for address in ("lcm:", "lcm:nowhere", "lcm:239.255.76.67:0/GO#00", "tcp:1", "", "lcm:#" * 90):
        office.answer = lambda entry, address=address: replace(entry, addresses=[address]).pack()
        client.tell(f"open {partner.name} 0.2")
        assert partner.name in client.says("not opened:"), address
    office.answer = lambda entry: entry.pack()
    client.opens(partner.name)


def test_a_key_that_is_not_admitted_is_ignored_and_asked_on(
    office: Office, partner: Partner, client: Client
) -> None:
    strange: list[bytes] = []

    def strangers_first(sent: bytes) -> list[bytes]:
        header = Header.of(sent)
        assert header is not None
        if header.kind != Datagram.KEY:
            return [sent]
        strange.append(sent[:16] + public_of(secrets.token_bytes(32)))
        cut = [sent[:-1], sent[:20], sent + b"\0", sent[:16] + bytes(32)]
        return [*cut, *strange] if len(strange) < 3 else [*cut, strange[-1], sent]

    office.listener.line = Through(strangers_first)
    client.opens(partner.name)
    assert len(strange) >= 3 and office.listener.asked >= 3


def test_nobody_at_the_place_of_the_broker_is_said_so(client: Client) -> None:
    client.tell("open ANYTHING 0.3")
    why = client.says("not opened:")
    assert "NO_SERVER" in why and BROKER_PLACE in why


def test_a_server_enlists_itself_and_serves_who_finds_it(
    office: Office, lab: Laboratory, loop: Loop, keys: Keys
) -> None:
    program = lab.start(lab.build / "tests/system/rail/rail_server", listens=True)
    loop.until(lambda: "RAIL" in office.entries, f"RAIL on the list: {program}")
    entry = office.entries["RAIL"]
    assert entry.interface == "lab::RailSensor" and "robcl::LaserDistanceSensor" in entry.bases
    assert entry.pid == program.pid and entry.boot != 0
    rail = Session(loop, entry.lcm_address, keys, "robcl::LaserDistanceSensor")
    assert rail.ready().boot == entry.boot
    reply = rail.call(MEASURE)
    assert reply.detail == Detail.DONE, Failure.of(reply.body)


def test_a_server_whose_name_is_not_settled_asks_on_and_does_not_move_until_it_is(
    office: Office, lab: Laboratory, loop: Loop, keys: Keys
) -> None:
    office.settles_in = 0.05
    rail = rail_of(office, lab, loop, keys)
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, f64(0.0))
    assert rail.call(MEASURE).detail == Detail.DONE
    loop.until(lambda: len(office.served_for) > 3, "it is asked again")
    assert not ride.over
    assert office.served_for == sorted(office.served_for) and office.served_for[0] == 0
    office.settles_in = None
    assert rail.finish(ride).detail == Detail.DONE
    rail.end()


def test_a_server_that_is_told_that_another_has_the_name_ends_its_leases(
    office: Office, lab: Laboratory, loop: Loop, keys: Keys
) -> None:
    office.settles_in = 0.05
    rail = rail_of(office, lab, loop, keys)
    rail.acquire(Status.ACTOR)
    ride = rail.start(TRAVEL, f64(0.0))
    office.taken_by = "the other one, pid 4711"
    ended = rail.finish(ride)
    assert ended.detail == Detail.STOPPED and office.taken_by in Failure.of(ended.body).text
    refused = rail.call(ACQUIRE, u32(Status.ACTOR))
    assert Failure.of(refused.body).exception == "gecos::StatusRefused"
    assert rail.call(MEASURE).detail == Detail.DONE
    rail.end()


def rail_of(office: Office, lab: Laboratory, loop: Loop, keys: Keys) -> Session:
    program = lab.start(lab.build / "tests/system/rail/rail_server", listens=True)
    loop.until(lambda: "RAIL" in office.entries, f"RAIL on the list: {program}")
    rail = Session(loop, office.entries["RAIL"].lcm_address, keys, "lab::RailSensor")
    rail.ready()
    return rail
