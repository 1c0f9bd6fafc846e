"""A laboratory suspended as a whole, and what stands there when it wakes up."""

from __future__ import annotations

import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from processes import Laboratory, Program, laboratory

HERE = Path(__file__).parent
SUSPENDED_S = 5.0


@dataclass
class Suspended:
    """Broker, server and holder of a ride, each a process."""

    lab: Laboratory
    server_command: list[str | Path]
    broker: Program
    server: Program
    holder: Program

    def start_broker(self) -> None:
        self.broker = start_broker(self.lab)

    def start_another_server(self) -> Program:
        """At a new broker, which does not know whose the name is: the record of the one before it
        is lost."""
        self.broker.kill()
        (Path(self.lab.env["GECOS_RUNTIME_DIR"]) / "BROKER.names").unlink()
        self.start_broker()
        return self.lab.start(*self.server_command, ready="serving RAIL")

    def stand_still(self, *programs: Program) -> None:
        for program in programs:
            program.signal(signal.SIGSTOP)

    def go_on(self, *programs: Program) -> None:
        for program in programs:
            program.signal(signal.SIGCONT)

    def says(self, what: str) -> str:
        self.holder.tell(what)
        return self.holder.wait_for(what)

    def until_says(self, what: str, text: str) -> str:
        began = time.monotonic()
        while text not in (said := self.says(what)):
            assert time.monotonic() - began < 10, f"{said}\n{self.server}"
        return said


def start_broker(lab: Laboratory) -> Program:
    broker = lab.build / "runtime/cpp/gecos/broker/gecos-broker"
    return lab.start(broker, "shm", ready="ready")


@contextmanager
def riding(
    build: Path, server_command: list[str | Path], holder_command: list[str | Path], medium: str
) -> Iterator[Suspended]:
    with tempfile.TemporaryDirectory(prefix="gecos-") as place:
        for lab in laboratory(Path(place), build):
            broker = start_broker(lab)
            server = lab.start(*server_command, ready="serving RAIL")
            holder = lab.start(*holder_command, medium, listens=True, ready="rides")
            yield Suspended(lab, server_command, broker, server, holder)
            holder.end_of_input()


def ended_by_the_pause(lab: Suspended) -> None:
    ride = lab.says("ride")
    assert "COMMAND_FAILED/FAULT" in ride and "stood still for" in ride


def broker_alive(lab: Suspended) -> None:
    everybody = lab.broker, lab.server, lab.holder
    lab.stand_still(*everybody)
    time.sleep(SUSPENDED_S)
    lab.go_on(*everybody)
    ended_by_the_pause(lab)
    assert "FINISHED/DONE" in lab.says("move"), "the broker confirms the name"
    assert "confirmed" in lab.says("name")


def broker_dead_on_waking(lab: Suspended) -> None:
    lab.stand_still(lab.broker, lab.server, lab.holder)
    time.sleep(SUSPENDED_S)
    lab.broker.kill()
    lab.go_on(lab.server, lab.holder)
    ended_by_the_pause(lab)
    for _ in range(2):
        move = lab.says("move")
        assert "CONNECTION_FAILED/NOT_STARTED" in move and "no broker confirms" in move
    assert "no broker confirms" in lab.says("name")
    assert "FINISHED/DONE" in lab.says("read")
    assert "FINISHED/DONE" in lab.says("stop")
    lab.start_broker()
    lab.until_says("move", "FINISHED/DONE")


def second_broker_on_waking(lab: Suspended) -> None:
    lab.stand_still(lab.broker, lab.server, lab.holder)
    time.sleep(SUSPENDED_S)
    lab.broker.kill()
    lab.start_broker()
    lab.go_on(lab.server, lab.holder)
    ended_by_the_pause(lab)
    assert "FINISHED/DONE" in lab.says("move"), "the successor confirms the name"


def another_server_meanwhile(lab: Suspended) -> None:
    lab.stand_still(lab.server, lab.holder)
    began = time.monotonic()
    other = lab.start_another_server()
    time.sleep(max(0, began + SUSPENDED_S - time.monotonic()))
    lab.go_on(lab.server, lab.holder)
    ended_by_the_pause(lab)
    move = lab.says("move")
    assert "COMMAND_FAILED/STOPPED" in move and f"pid {other.pid}" in move
    refused = lab.says("hold")
    assert "refused" in refused and f"pid {other.pid}" in refused
    assert "another server has the name" in lab.says("name")
    assert "FINISHED/DONE" in lab.says("read")
    told = [line for line in lab.server.lines if "is stopped and takes no actor commands" in line]
    assert len(told) == 1, lab.server
    other.kill()
    lab.until_says("hold", "granted")
    assert "FINISHED/DONE" in lab.says("move"), "the name is free again"


SCENES = (broker_alive, broker_dead_on_waking, second_broker_on_waking, another_server_meanwhile)


@pytest.mark.parametrize(
    ("holder", "servers"),
    [
        ("Python", {"C++": "shm", "Python": "lcm"}),
        ("C++", {"C++": "lcm", "Python": "shm"}),
    ],
)
def test_a_laboratory_that_wakes_up_moves_only_what_a_broker_says_is_its(
    holder: str, servers: dict[str, str], build: Path
) -> None:
    """All scenes at once, with a server of each language: they mostly stand still."""
    rail = build / "tests" / "system" / "rail"
    serve: dict[str, list[str | Path]] = {
        "C++": [rail / "rail_server"],
        "Python": [sys.executable, HERE / "rail" / "server.py"],
    }
    hold: dict[str, list[str | Path]] = {
        "C++": [rail / "ask_of_rail"],
        "Python": [sys.executable, HERE / "programs" / "ask_of_rail.py"],
    }

    def play(scene: Callable[[Suspended], None], server: str, medium: str) -> None:
        with riding(build, serve[server], hold[holder], medium) as lab:
            scene(lab)

    with ThreadPoolExecutor(len(servers) * len(SCENES)) as stages:
        played = [
            stages.submit(play, scene, server, medium)
            for server, medium in servers.items()
            for scene in SCENES
        ]
    failed = [error for scene in played if (error := scene.exception()) is not None]
    if failed:
        raise BaseExceptionGroup("scenes", failed)
