"""Two network namespaces as two hosts: who has the name of a server of the other host that ends,
freezes, or is cut off, and what a watcher on either host is told."""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hosts import Hosts
from processes import Laboratory, Program, until

NAME_HOLD = 4.0
"""The broker's setting here, in s; by default 10."""
RUNS_FOR_S = 3.0
"""The other broker is then too old to have started in the place of a broker that stands still."""
YOUNG_S = 1.5
"""A restarted broker gives names to servers with better claims for 1 s."""
GECOS = [sys.executable, "-m", "gecos.cli"]


def broker_of(build: Path, *media: str) -> tuple[str | Path, ...]:
    return build / "runtime/cpp/gecos/broker/gecos-broker", f"--name-hold={NAME_HOLD}", *media


@dataclass
class TwoHosts:
    """The broker is on host 0, and a watcher on each host."""

    hosts: Hosts
    labs: list[Laboratory]
    broker: Program
    watchers: list[Program]

    def start(self, host: int, *command: str | Path) -> Program:
        return self.labs[host].start(*self.hosts.on(host), *command)

    def serve(self, host: int) -> Program:
        server = self.labs[host].build / "tests/system/rail/rail_server"
        program = self.start(host, server)
        program.wait_for("serving RAIL")
        return program

    def gecos(self, host: int, *words: str) -> Program:
        program = self.start(host, *GECOS, *words)
        program.finish()
        return program

    def restart_broker(self, *media: str) -> None:
        self.broker = self.start(0, *broker_of(self.labs[0].build, *media))
        self.broker.wait_for("ready")

    def has_kept_the_name(self, server: Program) -> None:
        """After the first second of the broker, in which it may give a name to another server."""
        began = time.monotonic()
        until(lambda: time.monotonic() - began > YOUNG_S, "the broker gives no name away any more")
        (found,) = json.loads(self.gecos(0, "ls", "--json").output())
        assert found["pid"] == server.pid
        assert "is stopped" not in str(server)

    def told(self, presence: str) -> None:
        """The next that each watcher says is this."""
        for watcher in self.watchers:
            told = json.loads(watcher.wait_for("{"))
            assert (told["name"], told["presence"]) == ("RAIL", presence)


@pytest.fixture
def two(build: Path, env: dict[str, str]) -> Iterator[TwoHosts]:
    with Hosts() as hosts, tempfile.TemporaryDirectory(prefix="gecos-") as place:
        labs = []
        for host in range(2):
            folder = Path(place) / str(host)
            folder.mkdir(mode=0o700)
            labs.append(Laboratory(folder, build))
            labs[-1].env |= env | {"GECOS_LCM_TTL": "1", "GECOS_BROKER": "lcm"}
        try:
            broker = labs[0].start(*hosts.on(0), *broker_of(build), ready="ready")
            two = TwoHosts(hosts, labs, broker, [])
            two.watchers = [two.start(host, *GECOS, "ls", "--watch", "--json") for host in range(2)]
            yield two
            for watcher in two.watchers:
                watcher.signal(signal.SIGINT)
                watcher.finish()
        finally:
            for lab in reversed(labs):
                lab.close()


def silent_since(two: TwoHosts) -> float:
    (found,) = json.loads(two.gecos(0, "ls", "--json").output())
    assert found["name"] == "RAIL"
    return float(found["silent_since"])


def test_a_dead_server_of_another_host_is_silent_and_its_name_is_free_after_name_hold(
    two: TwoHosts,
) -> None:
    server = two.serve(1)
    two.told("ONLINE")
    server.kill()
    killed = time.time()
    two.told("SILENT")
    assert abs(silent_since(two) - killed) < 1.0
    # It asks again until it gets the name, for 10 s.
    two.serve(0)
    assert time.time() - killed > NAME_HOLD - 0.5, "the name was held since the last sign of life"
    two.told("ONLINE")


def test_the_name_of_a_frozen_server_of_another_host_is_set_free_by_hand(two: TwoHosts) -> None:
    frozen = two.serve(1)
    two.told("ONLINE")
    refused = two.gecos(1, "free", "RAIL")
    assert refused.finish() == 3
    assert "the broker still hears the server of this object" in refused.output()
    frozen.signal(signal.SIGSTOP)
    two.told("SILENT")
    freed = two.gecos(1, "free", "RAIL")
    assert freed.output() == "RAIL: free", str(freed)
    two.told("GONE")
    other = two.serve(0)
    two.told("ONLINE")
    frozen.signal(signal.SIGCONT)
    assert f"pid {other.pid}" in frozen.wait_for("is stopped and takes no actor commands")


@pytest.mark.parametrize("told", [True, False])
def test_a_restarted_broker_does_not_give_the_name_back_to_the_server_that_has_lost_it(
    two: TwoHosts, told: bool
) -> None:
    frozen = two.serve(1)
    two.told("ONLINE")
    frozen.signal(signal.SIGSTOP)
    two.told("SILENT")
    two.gecos(1, "free", "RAIL")
    other = two.serve(0)
    if told:
        frozen.signal(signal.SIGCONT)
        frozen.wait_for("is stopped and takes no actor commands")
    two.broker.kill()
    if not told:
        frozen.signal(signal.SIGCONT)
    two.restart_broker("lcm")  # reads no file with the names of the broker before
    two.has_kept_the_name(other)
    if not told:
        frozen.wait_for("is stopped and takes no actor commands")


def test_a_restarted_broker_does_not_give_the_name_back_to_a_server_that_was_cut_off(
    two: TwoHosts,
) -> None:
    """Nobody has told that server, which has served the object for longer."""
    cut_off = two.serve(1)
    two.told("ONLINE")
    two.hosts.cut()
    assert json.loads(two.watchers[0].wait_for("{"))["presence"] == "SILENT"
    other = two.serve(0)
    two.broker.kill()
    two.hosts.mend()
    two.restart_broker("lcm")  # reads no file with the names of the broker before
    two.has_kept_the_name(other)
    cut_off.wait_for("is stopped and takes no actor commands")


def test_a_broker_that_dies_in_its_first_second_passes_no_provisional_name_on(
    two: TwoHosts,
) -> None:
    server = two.serve(1)
    began = time.monotonic()
    until(lambda: time.monotonic() - began > YOUNG_S, "the broker has confirmed the name")
    two.broker.kill()
    server.signal(signal.SIGSTOP)  # so that the newcomer is the first to ask
    newcomer = two.start(0, two.labs[0].build / "tests/system/rail/rail_server")
    two.restart_broker()
    newcomer.wait_for("serving RAIL")
    two.broker.kill()
    server.signal(signal.SIGCONT)
    two.restart_broker()
    two.has_kept_the_name(server)


def test_a_server_that_was_cut_off_for_less_than_name_hold_has_its_name(two: TwoHosts) -> None:
    two.serve(1)
    two.told("ONLINE")
    here, there = two.watchers
    two.hosts.cut()
    assert json.loads(here.wait_for("{"))["presence"] == "SILENT"
    two.hosts.mend()
    assert json.loads(here.wait_for("{"))["presence"] == "ONLINE"
    listed = two.gecos(0, "ls", "--json")
    assert [one["silent_since"] for one in json.loads(listed.output())] == [None]
    # The watcher beyond the cut learns the same, or that nothing has changed when it asks late.
    later = [json.loads(line)["presence"] for line in there.lines[1:]]
    assert later in ([], ["SILENT"], ["SILENT", "ONLINE"])


def test_the_server_that_was_cut_off_for_longer_stops_if_another_one_has_its_name(
    two: TwoHosts,
) -> None:
    cut_off = two.serve(1)
    two.told("ONLINE")
    two.hosts.cut()
    assert json.loads(two.watchers[0].wait_for("{"))["presence"] == "SILENT"
    other = two.serve(0)
    two.hosts.mend()
    assert f"pid {other.pid}" in cut_off.wait_for("is stopped and takes no actor commands")


def test_a_server_of_the_brokers_host_frees_its_name_at_once_over_lcm(two: TwoHosts) -> None:
    server = two.serve(0)
    two.told("ONLINE")
    server.kill()
    two.told("GONE")
    two.serve(0)
    two.told("ONLINE")


def test_a_broker_of_another_host_does_not_take_the_place_of_one_that_stands_still(
    two: TwoHosts,
) -> None:
    two.labs[0].env["GECOS_LOG"] = "debug"
    server = two.serve(0)
    elsewhere = two.labs[1].build / "runtime/cpp/gecos/broker/gecos-broker"
    began = time.monotonic()
    two.start(1, elsewhere).wait_for("ready")
    until(lambda: time.monotonic() - began > RUNS_FOR_S, "the other broker is older than a pause")
    two.broker.signal(signal.SIGSTOP)
    server.wait_for("GWBROKER: connected")
    ended = server.wait_for("the session with BROKER ended")
    two.broker.signal(signal.SIGCONT)
    assert "this program closed the session" in ended, "the session with the other broker"


def test_a_server_in_a_container_counts_as_one_of_another_host(two: TwoHosts) -> None:
    """It has the broker's runtime directory, but its process is number 1 of its own PID
    namespace, which is another process of the broker's host."""
    server = two.labs[0].build / "tests/system/rail/rail_server"
    container = ("unshare", "--pid", "--fork", "--kill-child", "--mount-proc")
    outside = two.start(0, *container, server)
    outside.wait_for("serving RAIL")
    two.told("ONLINE")
    (found,) = json.loads(two.gecos(0, "ls", "--json").output())
    assert found["pid"] == 1
    (inside,) = Path(f"/proc/{outside.pid}/task/{outside.pid}/children").read_text().split()
    os.kill(int(inside), signal.SIGSTOP)
    two.told("SILENT")
    freed = two.gecos(0, "free", "RAIL")
    assert freed.output() == "RAIL: free", str(freed)
    two.told("GONE")
    os.kill(int(inside), signal.SIGKILL)
    outside.finish()
