"""What a broker announces, and to whom it gives the name of a server that ended or stands still."""

from __future__ import annotations

import json
import re
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable
from itertools import cycle
from pathlib import Path

import gecos
import pytest
from gecos import cli
from gecos_idl.broker import Broker
from gecos_idl.broker_types import NameInUse, UnknownName
from jsonschema import validate
from processes import Laboratory, Program, until

SCHEMA = json.loads((Path(cli.__file__).parent / "output.schema.json").read_text())
GECOS = [sys.executable, "-m", "gecos.cli"]
SERVER = Path(__file__).parent / "rail" / "server.py"
MANY = f"""
import runpy, sys, gecos
Rail = runpy.run_path({str(SERVER)!r})["Rail"]
names = sys.argv[1:]
gecos.serve({{name: Rail() for name in names}}, simulated=True)
"""
PATIENCE = 20.0
NAMES_BACK_WITHIN_S = 1.0
"""After the start of the next broker."""
SILENT_AFTER_S = 1.5
"""So long the broker does not hear the server. The limit itself is tested with a fake clock, in
object_host_test.cpp."""


def broker(lab: Laboratory, medium: str = "shm") -> Program:
    return lab.start(lab.build / "runtime/cpp/gecos/broker/gecos-broker", medium, ready="ready")


def rails(lab: Laboratory, *names: str) -> Program:
    return lab.start(sys.executable, "-c", MANY, *names, ready="serving")


def rails_in_cpp(lab: Laboratory, *names: str) -> Program:
    return lab.start(lab.build / "tests/system/rail/rail_server", *names, ready="serving")


def reach_broker_over(medium: str, lab: Laboratory, monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on, programs that are started and Labs that are made do so."""
    lab.env["GECOS_BROKER"] = medium
    monkeypatch.setenv("GECOS_BROKER", medium)


def next_of(watch: gecos.ObjectWatch) -> str:
    change = watch.next(PATIENCE)
    return f"{change.entry.name} {change.presence.name}"


def names_at(client: gecos.Lab) -> list[str]:
    try:
        return [one.name for one in client.objects(patience=0.1)]
    except gecos.CreateError:  # the client has not noticed yet that its broker is gone
        return []


@pytest.fixture
def watching(lab: Laboratory, here: None) -> Program:
    return broker(lab)


def test_a_watch_is_told_each_change_once(lab: Laboratory, watching: Program) -> None:
    with gecos.Lab() as client, client.watch() as watch:
        first = rails(lab, "ONE")
        assert next_of(watch) == "ONE ONLINE"
        second = rails(lab, "TWO")
        assert next_of(watch) == "TWO ONLINE"
        with client.watch("lab::RailSensor") as later, client.watch("robcl::Rx90") as other:
            assert [next_of(later), next_of(later)] == ["ONE ONLINE", "TWO ONLINE"]
            first.terminate()
            second.kill()
            for each in watch, later:
                assert [next_of(each), next_of(each)] == ["ONE GONE", "TWO GONE"]
                with pytest.raises(TimeoutError, match="within 0"):
                    each.next(0)
            with pytest.raises(TimeoutError):
                other.next(0)


def test_a_query_by_a_base_interface_finds_derived_ones(lab: Laboratory, watching: Program) -> None:
    rails(lab, "RAIL")
    with gecos.Lab() as client:
        for interface in "lab::RailSensor", "robcl::LaserDistanceSensor", "robcl::Device", None:
            assert [one.name for one in client.objects(interface)] == ["RAIL"], interface
        assert client.objects("robcl::Rx90") == []
    for interface, shown in ("robcl::LaserDistanceSensor", ["RAIL"]), ("robcl::Rx90", []):
        listed = lab.run(*GECOS, "ls", "--interface", interface, "--json")
        assert [one["name"] for one in json.loads(listed.output())] == shown


def is_confirmed(proxy: gecos.Object) -> bool:
    return gecos.describe(proxy).result().registration == "confirmed"


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_a_broker_that_is_killed_and_restarted_under_fifty_sessions_loses_nothing(
    lab: Laboratory, medium: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The broker is reached over `medium`; the objects are in servers of both languages."""
    from lab.rail_sensor import RailSensor

    reach_broker_over(medium, lab, monkeypatch)
    killed = broker(lab, medium)
    names = [f"RAIL{i}" for i in range(50)]
    for first, serve in zip(range(0, 50, 10), cycle([rails, rails_in_cpp])):
        serve(lab, *names[first : first + 10])
    with gecos.Lab() as client, client.watch() as watch:
        assert {next_of(watch) for _ in names} == {f"{name} ONLINE" for name in names}
        proxies = [client.create(RailSensor, name) for name in names]
        # A broker that has just started confirms names only after a while.
        until(lambda: all(map(is_confirmed, proxies)), "the names are confirmed")
        leases = [gecos.actor(proxy) for proxy in proxies]
        rides = [proxy.travel(1.0) for proxy in proxies]
        killed.kill()
        broker(lab, medium)

        took = until(lambda: len(names_at(client)) == 50, "all names are back")
        assert took < NAMES_BACK_WITHIN_S, f"{took:.3f} s"
        for ride in rides:
            ride.result(PATIENCE)
        assert [proxy.base().result().position[0] for proxy in proxies] == [1.0] * 50
        for lease in leases:
            lease.release()
        rails(lab, "ANOTHER")
        assert next_of(watch) == "ANOTHER ONLINE", "and nothing was told of the others"
        assert watch.skipped == 0


@pytest.mark.usefixtures("here")
def test_a_broker_that_stood_still_is_not_taken_for_another_one(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over lcm a server looks for a new broker as soon as its broker is silent."""
    reach_broker_over("lcm", lab, monkeypatch)
    lab.env["GECOS_LOG"] = "debug"
    frozen = broker(lab, "lcm")
    server = rails(lab, "RAIL")
    frozen.signal(signal.SIGSTOP)
    server.wait_for("did not answer: no server answers")
    frozen.signal(signal.SIGCONT)
    with gecos.Lab() as client:
        until(lambda: names_at(client) == ["RAIL"], "the object is listed")
    ends = [line for line in server.lines if "the session with BROKER ended" in line]
    server.terminate()
    assert "another broker has started" not in server.output()
    if "has been silent for" not in server.output():  # it may be, where the test was interrupted
        assert all("this program closed the session" in line for line in ends), ends


def test_a_server_that_does_not_return_to_the_next_broker_is_told_as_gone(
    lab: Laboratory, watching: Program
) -> None:
    rails(lab, "STAYS")
    ends = rails(lab, "ENDS")
    with gecos.Lab() as client, client.watch() as watch:
        assert [next_of(watch), next_of(watch)] == ["ENDS ONLINE", "STAYS ONLINE"]
        watching.kill()
        ends.kill()
        broker(lab)
        assert next_of(watch) == "ENDS GONE"


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("serve", [rails, rails_in_cpp])
def test_a_frozen_server_is_silent_after_the_time_that_is_promised(
    lab: Laboratory,
    serve: Callable[..., Program],
    medium: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reach_broker_over(medium, lab, monkeypatch)
    broker(lab, medium)
    frozen = serve(lab, "RAIL")
    with gecos.Lab() as client, client.watch() as watch:
        assert next_of(watch) == "RAIL ONLINE"
        frozen.signal(signal.SIGSTOP)
        stopped = time.monotonic()
        change = watch.next(PATIENCE)
        took = time.monotonic() - stopped
        assert change.presence.name == "SILENT"
        assert abs(took - SILENT_AFTER_S) < 0.5, f"{took} s"
        assert abs(change.silent_for - took) < 0.5, f"{change.silent_for} s of {took} s"


def test_a_frozen_server_of_this_host_keeps_its_name_until_its_process_ends(
    lab: Laboratory, watching: Program
) -> None:
    frozen = rails(lab, "RAIL")
    with gecos.Lab() as client, client.watch() as watch:
        assert next_of(watch) == "RAIL ONLINE"
        frozen.signal(signal.SIGSTOP)
        assert next_of(watch) == "RAIL SILENT"
        other = lab.run(lab.build / "tests/system/rail/rail_server")
        assert "its process still lives on the broker's host" in other.output()
        freed = lab.run(*GECOS, "free", "RAIL")
        assert freed.finish() == 3, str(freed)
        (line,) = freed.lines
        assert line.startswith("gecos: REJECTED: the name RAIL is not set free: the server process")
        assert f"end it with `kill -KILL {frozen.pid}`" in line
        with pytest.raises(NameInUse):
            client.broker(Broker).free("RAIL").result(PATIENCE)
        with pytest.raises(UnknownName):
            client.broker(Broker).free("NOBODY").result(PATIENCE)
        frozen.kill()
        assert next_of(watch) == "RAIL GONE"
        rails(lab, "RAIL")
        assert next_of(watch) == "RAIL ONLINE"


def test_a_frozen_server_keeps_its_name_when_the_broker_is_killed_and_restarted(
    lab: Laboratory, watching: Program
) -> None:
    frozen = rails(lab, "RAIL")
    with gecos.Lab() as client, client.watch() as watch:
        assert next_of(watch) == "RAIL ONLINE"
        frozen.signal(signal.SIGSTOP)
        names = Path(lab.env["GECOS_RUNTIME_DIR"]) / "BROKER.names"
        until(lambda: b"RAIL" in names.read_bytes(), "the name is certain and written down")
        watching.kill()
        broker(lab)
        other = lab.run(lab.build / "tests/system/rail/rail_server")
        assert (
            other.finish() != 0 and "its process still lives on the broker's host" in other.output()
        )
        assert next_of(watch) == "RAIL SILENT"
        assert lab.run(*GECOS, "free", "RAIL").finish() == 3
        frozen.kill()
        assert next_of(watch) == "RAIL GONE"
        rails(lab, "RAIL")
        assert next_of(watch) == "RAIL ONLINE"


def test_a_silent_server_is_silent_at_the_next_broker_and_comes_back(
    lab: Laboratory, watching: Program
) -> None:
    frozen = rails(lab, "RAIL")
    with gecos.Lab() as client, client.watch() as watch:
        assert next_of(watch) == "RAIL ONLINE"
        frozen.signal(signal.SIGSTOP)
        assert next_of(watch) == "RAIL SILENT"
        watching.terminate()
        broker(lab)

        def listed() -> list[int]:
            try:
                return [one.entry.pid for one in client.broker(Broker).silent().result(PATIENCE)]
            except ConnectionError:  # the client has not noticed yet that its broker is gone
                return []

        until(lambda: listed() == [frozen.pid], "the next broker calls it silent")
        frozen.signal(signal.SIGCONT)
        assert next_of(watch) == "RAIL ONLINE", "and nothing was told of it meanwhile"


def test_the_command_line_says_which_name_cannot_be_set_free(
    lab: Laboratory, watching: Program
) -> None:
    server = rails(lab, "RAIL")
    heard = lab.run(*GECOS, "free", "RAIL")
    assert heard.finish() == 3
    assert re.fullmatch(
        "gecos: REJECTED: the name RAIL is not set free: the broker still hears "
        "the server of this object, a "
        rf"lab::RailSensor of \S+ on \S+, pid {server.pid}; end that server",
        heard.output(),
    )
    unknown = lab.run(*GECOS, "free", "NOBODY", "--json")
    assert unknown.finish() == 4
    assert json.loads(unknown.output())["error"] == {
        "exit_code": 4,
        "text": "NOBODY: NO_SERVER: the broker has no silent object of this name; `gecos ls` shows "
        "the silent objects",
        "detail": "NO_SERVER",
        "state": "CONNECTION_FAILED",
    }


def test_a_frozen_server_that_goes_on_has_its_name(lab: Laboratory, watching: Program) -> None:
    frozen = rails(lab, "RAIL")
    with gecos.Lab() as client, client.watch() as watch:
        assert next_of(watch) == "RAIL ONLINE"
        frozen.signal(signal.SIGSTOP)
        assert next_of(watch) == "RAIL SILENT"
        frozen.signal(signal.SIGCONT)
        assert next_of(watch) == "RAIL ONLINE"
        assert [one.pid for one in client.objects()] == [frozen.pid]


def test_the_command_line_shows_changes_and_waits_for_one(
    lab: Laboratory, watching: Program
) -> None:
    shown = lab.start(*GECOS, "ls", "--watch")
    told = lab.start(*GECOS, "ls", "--watch", "--json", "--interface", "robcl::Device")
    waits = lab.start(*GECOS, "wait", "RAIL")
    server = rails(lab, "RAIL")
    assert waits.wait_for("RAIL: online")
    assert f"pid {server.pid}" in shown.wait_for("RAIL: online (lab::RailSensor, ")
    online = json.loads(told.wait_for("RAIL"))
    server.kill()
    shown.wait_for("RAIL: gone")
    gone = json.loads(told.wait_for("GONE"))
    for line in told.lines:
        validate(json.loads(line), SCHEMA | {"$ref": "#/$defs/ls --watch"})
    assert gone == online | {"presence": "GONE"}
    assert Counter(line.partition(" (")[0] for line in shown.lines) == {
        "RAIL: online": 1,
        "RAIL: gone": 1,
    }
    for each in shown, told:
        each.signal(signal.SIGINT)
        assert each.finish() == 130


def test_create_waits_for_an_object_and_for_a_broker(lab: Laboratory, here: None) -> None:
    from lab.rail_sensor import RailSensor

    with gecos.Lab() as client, pytest.raises(gecos.CreateError):
        client.create(RailSensor, "RAIL", wait=0.2)
    begun = time.monotonic()
    waits = lab.start(*GECOS, "wait", "RAIL", "--timeout", "30", "--json")
    broker(lab)
    rails(lab, "RAIL")
    assert waits.finish() == 0, str(waits)
    assert time.monotonic() - begun < 30
