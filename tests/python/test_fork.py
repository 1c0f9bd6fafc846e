"""A program that forks while it calls and serves: what the child inherits is its parent's."""

from __future__ import annotations

from pathlib import Path

import gecos
import pytest
from lamp import PlainLamp
from test_process import running

REFUSED = """
def refused(what):
    try:
        what()
    except RuntimeError as error:
        assert "belongs to the process that forked this one" in str(error), error
    else:
        raise AssertionError("not refused")
"""

PARENT = (
    """
import asyncio, gecos, os, sys, threading, warnings
from lamp import Lamp, PlainLamp

# From Python 3.12 on every fork of a process with threads warns.
warnings.filterwarnings("ignore", ".* is multi-threaded", DeprecationWarning)

lab = gecos.Lab()
server = gecos.Server(lab)
server.add("MINE", PlainLamp(), simulated=True)
mine = gecos.Lab().create(Lamp, "MINE", medium="shm")
lamp = lab.create(Lamp, "LAMP", medium="shm")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.detach()
stream = lamp.level.stream()
over = threading.Event()

def busy(proxy):
    while not over.is_set():
        proxy.label().result(30)

threads = [threading.Thread(target=busy, args=(proxy,)) for proxy in (mine, lamp)]
for thread in threads:
    thread.start()

"""
    + REFUSED
    + """
for _ in range(20):
    child = os.fork()
    if child == 0:
        over.set()
{child}
        sys.exit(0)
    _, status = os.waitpid(child, 0)
    assert status == 0, status
over.set()
for thread in threads:
    thread.join()
assert burning.state is gecos.State.RUNNING
burning.cancel()
burning.wait(30)
print("well", flush=True)
"""
)

CHILDREN = {
    "ends": "pass",
    "closes": "lease.release(); stream.close(); server.close(); lab.close()",
    "drops": "del lease, stream, server, lab, mine, lamp, burning",
    "asks": "[refused(what) for what in (lamp.label, burning.wait, stream.next, stream.latest, "
    "lambda: lab.create(Lamp, 'LAMP'), lambda: server.add('X', PlainLamp()), "
    "lambda: burning.add_done_callback(print), lambda: asyncio.run(asyncio.wait_for(burning, 9)), "
    "lambda: gecos.actor(lamp), lambda: gecos.stop(lamp))]",
    "makes its own": "assert gecos.Lab().create(Lamp, 'LAMP').label().result(30) == 'a lamp'",
}

TRIES = 5
"""A busy machine may let the server of this test, or the program, stand still for more than 500 ms.
Then the running command ends, as it must: such a try shows nothing about forks."""


@pytest.mark.parametrize("child", CHILDREN)
def test_a_forked_child_ends_and_leaves_its_parent_alone(
    lab: gecos.Lab,
    server: gecos.Server,
    servant: PlainLamp,
    child: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    for _ in range(TRIES):
        with running(PARENT.replace("{child}", "        " + CHILDREN[child])) as program:
            out, err = program.communicate(timeout=60)
        if "this process stood still" not in capfd.readouterr().err + err:
            break
    assert (out, err, program.returncode) == ("well\n", "", 0)


READING = (
    """
import gecos, os, sys, threading, warnings
from lamp import Lamp

warnings.filterwarnings("ignore", ".* is multi-threaded", DeprecationWarning)
stream = gecos.Lab().create(Lamp, "LAMP", medium="shm").level.stream()
"""
    + REFUSED
    + """
def read():
    try:
        stream.next()
    except EOFError:
        print("closed", flush=True)

def waits():
    try:
        stream.latest()
    except RuntimeError:
        return True
    return False

reader = threading.Thread(target=read)
reader.start()
while not waits():
    pass
child = os.fork()
if child == 0:
    for what in (stream.next, lambda: stream.next(30), stream.latest, stream.history):
        refused(what)
    os._exit(0)
print(os.waitpid(child, 0)[1], flush=True)
stream.close()
reader.join()
"""
)


@pytest.mark.usefixtures("server")
def test_a_child_does_not_wait_for_the_reader_that_its_parent_has() -> None:
    with running(READING) as program:
        out, err = program.communicate(timeout=60)
        assert (out, err, program.returncode) == ("0\nclosed\n", "", 0)


DYNAMIC = """
import gecos, os, warnings

warnings.filterwarnings("ignore", ".* is multi-threaded", DeprecationWarning)
gecos.dynamic("BROKER").list().result(30)
child = os.fork()
if child == 0:
    gecos.dynamic("BROKER").list().result(30)
    print("well", flush=True)
    os._exit(0)
print(os.waitpid(child, 0)[1], flush=True)
"""


@pytest.mark.usefixtures("lab")
def test_a_child_has_a_lab_of_its_own_for_dynamic() -> None:
    with running(DYNAMIC) as program:
        out, err = program.communicate(timeout=60)
        assert (out, err, program.returncode) == ("well\n0\n", "", 0)


BROKER = """
import gecos, os, sys, warnings
from lamp import Lamp, PlainLamp

warnings.filterwarnings("ignore", ".* is multi-threaded", DeprecationWarning)

lab = gecos.Lab()
broker = gecos.Broker(lab)
server = gecos.Server(lab)
server.add("LAMP", PlainLamp(), simulated=True)
child = os.fork()
if child == 0:
    print(gecos.Lab().create(Lamp, "LAMP").label().result(30), flush=True)
    os._exit(0)
os.waitpid(child, 0)
"""


def test_a_forked_child_finds_the_broker_of_its_parent(place: Path) -> None:
    with running(BROKER) as program:
        out, err = program.communicate(timeout=60)
        assert (out, err, program.returncode) == ("a lamp\n", "", 0)
