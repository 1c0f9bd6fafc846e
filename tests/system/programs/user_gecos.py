"""Serves a broker and LAMP as the user `gecos`. The users `daemon` and `bin` of this host use LAMP,
one after the other. The argument is the folder of the module `lamp`. All processes are forked here,
because another user may not be able to read the tree."""

import os
import pwd
import sys
from collections.abc import Callable
from pathlib import Path

import gecos

sys.path.insert(0, sys.argv[1])
from lamp import Lamp, PlainLamp

PREPARED = (gecos.Broker, gecos.Server, gecos.Lab)  # loads their modules before the forks


def fork_as(user: str, program: Callable[[int, int], None]) -> tuple[int, int, int]:
    """Runs `program` in a process of `user`. Returns the process, and two pipes: one from which a
    line of the program can be read, and one that lets it go on."""
    entry = pwd.getpwnam(user)
    hears, says = os.pipe()
    waits, goes = os.pipe()
    process = os.fork()
    if process != 0:
        os.close(says)
        return process, hears, goes
    os.setgroups([])
    os.setgid(entry.pw_gid)
    os.setuid(entry.pw_uid)
    program(says, waits)
    os._exit(0)


def serve(says: int, waits: int) -> None:
    with gecos.Lab() as lab, gecos.Broker(lab), gecos.Server(lab) as server:
        server.add("LAMP", PlainLamp(), media=["shm"])
        os.write(says, b"serves\n")
        os.read(waits, 1)


def use(says: int, waits: int) -> None:
    os.read(waits, 1)
    try:
        said = gecos.Lab().create(Lamp, "LAMP", patience=10.0).label().result()
    except gecos.CreateError as refused:
        said = str(refused)
    os.write(says, said.encode() + b"\n")


_, server_says, server_goes = fork_as("gecos", serve)
if os.read(server_says, 100) != b"serves\n":
    sys.exit("the user gecos cannot serve LAMP")
folder = Path(os.environ["GECOS_RUNTIME_DIR"]) / f"gecos-{pwd.getpwnam('gecos').pw_uid}"
modes = [path.stat().st_mode & 0o777 for path in (folder, folder / "BROKER.sock")]
print("{} serves in a folder of mode {:o}, at a socket of mode {:o}".format(folder.owner(), *modes))
for user in ("daemon", "bin"):
    _, client_says, client_goes = fork_as(user, use)
    os.write(client_goes, b"g")
    with os.fdopen(client_says) as lines:
        print(f"{user}: {lines.readline().strip()}")
os.write(server_goes, b"g")
