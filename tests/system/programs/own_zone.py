"""Serves CELL, a zone whose servant does not look who reports, until SIGTERM."""

import signal

import gecos
from gecos_idl.presence import ZonePresence, ZoneServant


class OwnZone(ZoneServant):
    def presence(self) -> ZonePresence:
        return ZonePresence(False, 1, "nobody looks")

    def show_code(self) -> None: ...
    def check_in(self, code: str, person: str, stay: float) -> None: ...
    def check_out(self, person: str) -> bool:
        return False

    def report_door(self, door: str, closed: bool) -> None: ...
    def report_button(self, button: str, held: bool) -> None: ...


with gecos.Lab() as lab, gecos.Server(lab) as server:
    server.add("CELL", OwnZone(), simulated=True)
    print("ready", flush=True)
    signal.pause()
