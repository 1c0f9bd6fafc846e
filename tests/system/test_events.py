"""Events: every server to every client over every medium, clients without generated code, and the
command line."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import gecos
import pytest
from button import Alarm
from gecos.proxy import Event
from gecos.record import replace
from jsonschema import Draft202012Validator
from processes import Laboratory, Program, until

HERE = Path(__file__).parent / "events"
COMMAND = [sys.executable, "-m", "gecos.cli"]

TRANSCRIPT = """\
before: nothing
ann with 2.5 N, missed 0
ann with 2.5 N, missed 0
lifted: 40
without a lease: DENIED
silenced: 7
"""


def program(lab: Laboratory, language: str, role: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "tests" / "system" / "events" / f"events_{role}"]
    return [sys.executable, HERE / f"{role}.py"]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_events_of_every_server_reach_every_client(
    server: str, client: str, medium: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, server, "server"), ready="serving")
    heard = lab.run(*program(lab, client, "client"), medium)
    assert heard.output().splitlines() == TRANSCRIPT.splitlines(), str(heard)


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("server", ["C++", "Python"])
@pytest.mark.usefixtures("here")
def test_a_client_without_generated_code_hears_them(
    server: str, medium: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, server, "server"), ready="serving")
    with gecos.Lab() as mine:
        alarm = mine.dynamic("ALARM", medium=medium)
        assert type(alarm).pressed.__doc__ == "Somebody pressed the button."
        with alarm.pressed.stream() as pressed, alarm.lifted.stream() as lifted:
            alarm.press("ann", 2.5, 1).result()
            alarm.lift(1).result()
            event = pressed.next(30)
            assert (event.value, event.lost) == ({"who": "ann", "force": 2.5}, 0)
            assert lifted.next(30).value == {}


@pytest.mark.usefixtures("here")
def test_an_event_has_neither_a_value_nor_a_caller(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, "Python", "server"), ready="serving")
    with gecos.Lab() as mine:
        alarm = mine.create(Alarm, "ALARM")
        with pytest.raises(TypeError, match=r"pressed is an event.*`\.pressed\.stream\(\)`"):
            alarm.pressed()
        with pytest.raises(TypeError, match="is an event"):
            alarm.pressed("ann", force=2.5)
        assert repr(alarm.pressed).startswith("<event pressed of <buttons::Alarm 'ALARM' over ")
    read = lab.run(*COMMAND, "get", "ALARM", "pressed")
    assert read.finish() == 2, str(read)
    assert "ALARM.pressed is an event, which can neither be called nor read or set" in read.output()


@pytest.mark.usefixtures("here")
def test_an_event_that_the_server_defines_otherwise_is_refused_and_the_rest_works(
    lab_with_broker: Laboratory,
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, "C++", "server"), ready="serving")
    known = Alarm._gecos_interface
    other = [replace(s, hash=1) if s.name == "pressed" else s for s in known.streams]

    class Older(Alarm):
        _gecos_interface = replace(known, streams=tuple(other), hash=2)

    with gecos.Lab() as mine:
        alarm = mine.create(Older, "ALARM")
        with pytest.raises(gecos.ConnectionFailed, match="'pressed' of ALARM was not opened: "):
            alarm.pressed.stream()
        with alarm.lifted.stream() as lifted:
            alarm.lift(1).result()
            assert lifted.next(30).lost == 0


@pytest.mark.usefixtures("here")
def test_an_event_that_the_server_does_not_know_is_named(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, "C++", "server"), ready="serving")
    known = Alarm._gecos_interface
    other = [replace(s, code=4711) if s.name == "pressed" else s for s in known.streams]

    class Newer(Alarm):
        _gecos_interface = replace(known, streams=tuple(other), hash=2)

        @property
        def pressed(self) -> Event[Any]:
            table = super().pressed._event
            return Event(self, replace(table, stream=replace(table.stream, code=4711)))

    with gecos.Lab() as mine:
        alarm = mine.create(Newer, "ALARM")
        with pytest.raises(
            gecos.CommandFailed, match="no stream 'pressed' of ALARM and may be older"
        ):
            alarm.pressed.stream()


def test_the_command_line_shows_events(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, "Python", "server"), ready="serving")
    told = lab.run(*COMMAND, "describe", "ALARM").output()
    assert "pressed(who: string<20>, force: double [N, 0.0 to 10.0])" in told
    assert "silenced(zone: int32 = 1)  (watch: actor)" in told
    watch = lab.start(*COMMAND, "watch", "ALARM", "pressed", "--json", "--count", "1")

    def is_shown() -> bool:
        lab.run(*COMMAND, "call", "ALARM", "press", "who=ann", "force=2", "times=1")
        return not watch.running()

    until(is_shown, "the event is shown")
    assert watch.finish() == 0, str(watch)
    assert json.loads(watch.output())["value"] == {"who": "ann", "force": 2.0}


def test_events_are_printed_as_they_occur(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, "C++", "server"), ready="serving")
    shown = lab.start(*COMMAND, "events", "ALARM", "--json", "--count", "2")

    def are_shown() -> bool:
        lab.run(*COMMAND, "call", "ALARM", "lift", "times=1")
        return not shown.running()

    until(are_shown, "two events are shown")
    assert shown.finish() == 0, str(shown)
    first, second = map(json.loads, shown.output().splitlines())
    schema = json.loads(lab.run(*COMMAND, "schema").output())
    Draft202012Validator(schema | {"$ref": "#/$defs/events"}).validate(first)
    assert (first["event"], first["value"]) == ("lifted", {})
    assert second["sequence"] == first["sequence"] + 1
    one = lab.start(*COMMAND, "events", "ALARM", "silenced", "--count", "1")
    until(lambda: "zone" in heard_when_silenced(lab, one), "the event is shown")
    assert '  silenced  {"zone": 3}' in one.output()


def heard_when_silenced(lab: Laboratory, one: Program) -> str:
    lab.run(*COMMAND, "call", "ALARM", "silence", "zone=3")
    return one.output()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["ALARM", "rung"], "ALARM (buttons::Alarm) has no event 'rung'; it has pressed, lifted"),
        (["NOBODY"], "NOBODY"),
    ],
)
def test_events_that_there_are_not(
    words: list[str], said: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    lab.start(*program(lab, "Python", "server"), ready="serving")
    done = lab.run(*COMMAND, "events", *words)
    assert done.finish() in (2, 4)
    assert said in done.output()


def test_the_end_of_the_server_ends_the_printing(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    server = lab.start(*program(lab, "C++", "server"), ready="serving")
    shown = lab.start(*COMMAND, "events", "ALARM", "pressed")

    def is_heard() -> bool:
        lab.run(*COMMAND, "call", "ALARM", "press", "who=ann", "force=2", "times=1")
        return "ann" in shown.output()

    until(is_heard, "an event is shown")
    server.terminate()
    assert shown.finish() == 4, str(shown)
    assert "the server closed the session with ALARM" in shown.output()
