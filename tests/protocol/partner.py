"""The object that the speaker serves to our clients: a speaking::Partner."""

from __future__ import annotations

import itertools
import json
import os
import secrets
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from speaker import broker
from speaker.client import Session as Office
from speaker.lcm import BROKER_PLACE, Loop
from speaker.noise import Keys
from speaker.packets import Kind, Packet, Reader, Status, Welcome, code_of, string, u32
from speaker.server import Served
from speaker.streams import StreamWriter
from speaker.tasks import Operation, Task

INTERFACE = "speaking::Partner"
_numbers = itertools.count(1)


def code(name: str) -> int:
    return code_of(f"{INTERFACE}::{name}")


def mirrored(task: Task) -> None:
    load = Reader(task.parameters).rest()[4:]
    task.done(u32(len(load)) + load[::-1])


def counted(task: Task) -> None:
    """The number that it was given, and one."""
    task.done(u32(Reader(task.parameters).u32() + 1))


HANDLERS: dict[str, Callable[[Task], None]] = {
    "mirror": mirrored,
    "mark": counted,
    "read": counted,
}


def operations_of(members: list[dict[str, object]]) -> list[Operation]:
    """What the model says, and what code the document gives each name."""
    operations = []
    for member in members:
        name = str(member["name"])
        told = member["code"] if "code" in member else member["codes"]["get"]  # type: ignore[index]
        assert told == code(name)
        actor = member.get("access") == "actor"
        operations.append(
            Operation(
                name=name,
                code=code(name),
                hash=int(str(member["hash"]), 16),
                status=Status.ACTOR if actor else Status.SENSOR,
                cancelable=bool(member.get("cancelable")),
                handler=HANDLERS.get(name),
            )
        )
    return operations


class Partner(Served):
    def __init__(self, loop: Loop, keys: Keys, model: Path) -> None:
        declared = json.loads(model.read_text())["declarations"]
        interface = next(one for one in declared if one["name"] == INTERFACE)
        operations = operations_of(interface["members"])
        name = f"PARTNER{next(_numbers)}"
        hashes = {operation.code: operation.hash for operation in operations}
        boot = secrets.randbits(64)
        about = Welcome(name, INTERFACE, [], int(interface["hash"], 16), boot, 0, hashes)
        super().__init__(loop, keys, about, operations)
        self.level = self.streams[code("level")] = StreamWriter(loop.mouth, largest=8 + 8)
        # A client that a busy machine keeps from running is not what these tests are about.
        self.status_silent_s = self.listener.silent_s = 60.0
        self._office: Office | None = None

    @property
    def name(self) -> str:
        return self.about.name

    def enlist(self) -> None:
        """Open as long as the session with the broker is."""
        self._office = Office(self.loop, BROKER_PLACE, self.listener.keys, "gecos::Broker")
        self._office.ready()
        broker.enlist(self._office, self.entry("speaker", "nowhere", os.getpid()))

    def close(self) -> None:
        if self._office:
            self._office.end()
            self._office.close()
        super().close()

    def answers_by_hand(self, name: str) -> None:
        """From now on the test ends its tasks."""
        self.operations[code(name)] = replace(self.operations[code(name)], handler=None)

    def task(self, name: str, nth: int = 0) -> Task:
        """The nth task of this operation, which may have to come first."""

        def those() -> list[Task]:
            return [task for task in self.tasks if task.operation.name == name]

        self.loop.until(lambda: len(those()) > nth, f"{name}, call {nth + 1}")
        return those()[nth]

    def packets(self, kind: Kind) -> list[Packet]:
        """What came in the newest session."""
        return [packet for packet in self.session.received if packet.kind == kind]

    def awaits(self, kind: Kind, many: int = 1) -> list[Packet]:
        self.loop.until(lambda: len(self.packets(kind)) >= many, f"{kind.name}, {many} of them")
        return self.packets(kind)


def step(at: int, where: str) -> bytes:
    """A speaking::Step."""
    return u32(at) + string(where)
