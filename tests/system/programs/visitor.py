"""Starts a broker and serves LAMP and OTHER as root. LAMP admits the user `daemon`, by its program
alone. The users `daemon` and `bin` look for objects, as `gecos ls` does. The arguments are the
folder of the module `lamp`, and the program of the broker. The children are forked here, because
another user may not be able to read the tree."""

import contextlib
import io
import os
import pwd
import socket
import subprocess
import sys
import tomllib  # noqa: F401
from collections.abc import Callable

import gecos

# Imported here, because a child may not be able to read the modules.
from gecos.cli import app, policy, policy_asked, refusal, report  # noqa: F401
from gecos.cli.doctor.broker import Answer, BrokerPlace, broker
from gecos.cli.presence import presences
from gecos.dynamic_client import connect  # noqa: F401
from gecos_idl.broker import Broker

sys.path.insert(0, sys.argv[1])
from lamp import Lamp, PlainLamp


def names(lab: gecos.Lab) -> str:
    return " ".join(one.entry.name for one in presences(lab, ""))


def look() -> str:
    with gecos.Lab("shm") as lab:
        try:
            said = f"{names(lab)}: {lab.create(Lamp, 'LAMP', wait=10.0).label().result()}"
        except (gecos.CreateError, ConnectionError) as refused:
            return str(refused)
    return said


def stop_the_broker() -> str:
    with gecos.Lab("shm") as lab:
        try:
            gecos.stop(lab.broker(Broker)).result()
        except gecos.CommandFailed as refused:
            return str(refused)
    return "stopped"


def policy_tested() -> str:
    """Returns what `gecos policy test` says to a user about this user, and its exit code."""
    user = pwd.getpwuid(os.geteuid()).pw_name
    os.environ["GECOS_BROKER"] = "shm"
    sys.argv = ["gecos", "policy", "test", user, socket.gethostname(), "LAMP"]
    with contextlib.redirect_stdout(io.StringIO()) as said:
        code = app.run()
    return f"{int(code)}: {' / '.join(said.getvalue().splitlines())}"


def advice() -> str:
    """Returns what `gecos doctor` advises if the broker refuses this user."""
    with gecos.Lab("shm") as lab:
        try:
            lab.broker(Broker)
        except gecos.CreateError as refused:
            return broker(Answer(refused.attempts[0].reason), BrokerPlace(), "").mend or ""
    return "admitted"


def program_of(user: str, *tasks: Callable[[], str]) -> tuple[int, int]:
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
    for task in tasks:
        print(f"{user}: {task()}", flush=True)
    os._exit(0)


programs = [
    program_of("daemon", look, stop_the_broker, policy_tested),
    program_of("bin", look, policy_tested, advice),
]
with subprocess.Popen([sys.argv[2], "shm"], stdout=subprocess.PIPE, text=True) as running:
    assert running.stdout is not None
    running.stdout.readline()
    with gecos.Lab("shm") as lab, gecos.Server(lab) as server, gecos.Server(lab) as other:
        server.allow(["daemon"])
        server.add("LAMP", PlainLamp(), media=["shm"])
        other.add("OTHER", PlainLamp(), media=["shm"])
        print("root:", names(lab), flush=True)
        for process, goes in programs:
            os.write(goes, b"g")
            os.waitpid(process, 0)
    running.terminate()
