"""Serves LAMP as root. The users `daemon` and `bin` of this host use it, one after the other. The
argument is the folder of the module `lamp`. The children are forked here, because another user may
not be able to read the tree."""

import os
import pwd
import sys

import gecos

sys.path.insert(0, sys.argv[1])
from lamp import Lamp, PlainLamp


def program_of(user: str) -> tuple[int, int]:
    """Returns the process of a program of `user`, and a pipe that lets it go on."""
    entry = pwd.getpwnam(user)
    waits, goes = os.pipe()
    process = os.fork()
    if process != 0:
        return process, goes
    os.read(waits, 1)
    os.setgroups([])
    os.setgid(entry.pw_gid)
    os.setuid(entry.pw_uid)
    try:
        said = gecos.Lab().create(Lamp, "LAMP", patience=10.0).label().result()
    except gecos.CreateError as refused:
        said = str(refused)
    print(f"{user}: {said}", flush=True)
    os._exit(0)


programs = [program_of("daemon"), program_of("bin")]
with gecos.Lab() as lab, gecos.Broker(lab), gecos.Server(lab) as server:
    server.allow(["daemon"])
    server.add("LAMP", PlainLamp(), media=["shm"])
    for process, goes in programs:
        os.write(goes, b"g")
        os.waitpid(process, 0)
