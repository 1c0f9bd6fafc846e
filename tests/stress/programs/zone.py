"""Serves the zone of the Workbench: a person comes and leaves at random instants, and each is noted
before it is published."""

from __future__ import annotations

import os
import random
import signal
import threading
import time

import gecos
from gecos_idl.presence import ZonePresence, ZoneServant
from record import Balance, Record, settings

REPORT_EVERY_S = 0.1
LONGEST_STAY_S = 2.5
LONGEST_ABSENCE_S = 1.0


class Zone(ZoneServant):
    """Publishes whether the person is there. The sources of a real zone are missing."""

    def __init__(self) -> None:
        super().__init__()
        self.report = ZonePresence(False, time.time_ns(), "the person has left")

    def presence(self) -> ZonePresence:
        return self.report

    def show_code(self) -> None: ...
    def check_in(self, code: str, person: str, stay: float) -> None: ...
    def check_out(self, person: str) -> bool:
        return False

    def report_door(self, door: str, closed: bool) -> None: ...
    def report_button(self, button: str, held: bool) -> None: ...

    def say(self, present: bool) -> None:
        spell = self.report.spell + int(present)
        self.report = ZonePresence(present, spell, "there" if present else "the person has left")
        self.publish_presence(self.report)


def come_and_leave(zone: Zone, record: Record, chance: random.Random, end: threading.Event) -> None:
    present = False
    while not end.is_set():
        present = not present
        record.note("comes" if present else "leaves")
        zone.say(present)
        longest = LONGEST_STAY_S if present else LONGEST_ABSENCE_S
        until = time.monotonic() + chance.uniform(0.02, longest)
        while not end.is_set() and (left := until - time.monotonic()) > 0:
            end.wait(min(left, REPORT_EVERY_S))
            zone.publish_presence(zone.report)


def main() -> None:
    setting = settings()
    record = Record(setting["record"])
    end = threading.Event()
    signal.signal(signal.SIGTERM, lambda _number, _frame: end.set())
    balance = Balance()
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        zone = Zone()
        server.add("CELL", zone, simulated=True, media=[setting["medium"]])
        record.note(f"zone {os.getpid()}")
        print("ready", flush=True)
        come_and_leave(zone, record, random.Random(int(setting["seed"])), end)
    balance.close()
    record.note("done")


if __name__ == "__main__":
    main()
