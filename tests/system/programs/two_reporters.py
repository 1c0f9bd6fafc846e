"""A zone of root, whose door is reported by root and by the user `daemon`: before and after an edit
of the lab file names `daemon` as the owner of the door. The arguments are the command that serves
the zone. The child is forked here, because another user may not be able to read the tree."""

import os
import pwd
import socket
import subprocess
import sys
import time
from pathlib import Path

import gecos
from gecos_idl.presence import Zone

PATIENCE_S = 30.0


def report(zone: Zone) -> str:
    try:
        zone.report_door("DOOR", True).result()
    except gecos.CommandFailed as refused:
        return str(refused)
    return "reported"


def door_of_daemon() -> tuple[int, int, int]:
    """Returns the process of a program of `daemon`, a pipe that makes it report, and one from which
    what came of that can be read."""
    entry = pwd.getpwnam("daemon")
    waits, goes = os.pipe()
    hears, says = os.pipe()
    process = os.fork()
    if process != 0:
        os.close(waits)
        return process, goes, hears
    os.close(goes)
    os.setgroups([])
    os.setgid(entry.pw_gid)
    os.setuid(entry.pw_uid)
    zone = None
    while os.read(waits, 1):
        zone = zone or gecos.Lab().create(Zone, "CELL", patience=10.0)
        os.write(says, report(zone).encode())
    os._exit(0)


process, goes, hears = door_of_daemon()


def daemon_reports() -> str:
    os.write(goes, b"g")
    return os.read(hears, 4096).decode()


with gecos.Lab() as lab, gecos.Broker(lab):
    zone_program = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE, text=True)
    assert zone_program.stdout is not None
    assert "ready" in zone_program.stdout.readline()
    root_zone = lab.create(Zone, "CELL")
    print("root:", report(root_zone))
    print("daemon:", daemon_reports())
    with Path(os.environ["GECOS_LAB_FILE"]).open("a") as lab_file:
        lab_file.write(f'[objects.CELL.sources]\nDOOR = "daemon@{socket.gethostname()}"\n')
    give_up = time.monotonic() + PATIENCE_S
    while (last := daemon_reports()) != "reported" and time.monotonic() < give_up:
        pass
    print("daemon:", last)
    print("root:", report(root_zone))
    os.close(goes)
    os.waitpid(process, 0)
    zone_program.terminate()
    zone_program.wait()
