"""What only a process of its own can show: signals, and the end of a program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import gecos
from lamp import Lamp, PlainLamp

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]


def start(program: str) -> subprocess.Popen[str]:
    path = [str(HERE), *sys.path]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, path))}
    return subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


WAITING = """
import gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="shm")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
print("waiting", flush=True)
try:
    burning.wait()
except KeyboardInterrupt:
    print("interrupted", burning.state.name, flush=True)
    burning.cancel()
"""


def test_ctrl_c_ends_a_wait(server: gecos.Server, servant: PlainLamp) -> None:
    client = start(WAITING)
    assert client.stdout is not None
    assert client.stdout.readline() == "waiting\n"
    servant.burning.wait()
    client.send_signal(signal.SIGINT)
    out, err = client.communicate(timeout=30)
    assert out == "interrupted RUNNING\n"
    assert client.returncode == 0, err


LEAVING = """
import gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="{medium}")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.detach()
lamp.dim(2.0).detach()
"""


def test_what_was_issued_runs_on_after_the_program_has_ended(
    lab: gecos.Lab, server: gecos.Server, servant: PlainLamp
) -> None:
    servant.value = 8.0
    client = start(LEAVING.format(medium="shm"))
    _, err = client.communicate(timeout=30)
    assert client.returncode == 0, err
    assert err == ""
    assert servant.burning.wait(30)
    servant.finish.set()
    lamp = lab.create(Lamp, "LAMP")
    while lamp.level().result() != 4.0:
        assert not servant.interrupted.is_set()
    while gecos.holders(lamp).result():
        pass
    assert servant.starts == ["burn_in", "dim"]


KILLED = """
import gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="shm")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
print("moving", flush=True)
burning.wait()
"""


def test_when_the_holder_is_killed_what_it_moved_is_interrupted(
    lab: gecos.Lab, server: gecos.Server, servant: PlainLamp
) -> None:
    client = start(KILLED)
    assert client.stdout is not None
    assert client.stdout.readline() == "moving\n"
    servant.burning.wait()
    client.kill()
    client.communicate(timeout=30)
    assert servant.interrupted.wait(30)


SERVING = """
import gecos
from lamp import PlainLamp
lamp = PlainLamp()
gecos.serve({"LAMP": lamp}, simulated=True)
print("left", flush=True)
"""


def test_serve_ends_with_sigterm(lab: gecos.Lab) -> None:
    server = start(SERVING)
    assert server.stdout is not None
    assert server.stdout.readline() == "serving LAMP\n"
    lamp = lab.create(Lamp, "LAMP")
    assert lamp.label().result() == "a lamp"
    server.send_signal(signal.SIGTERM)
    out, err = server.communicate(timeout=30)
    assert (out, server.returncode) == ("left\n", 0), err


def test_a_killed_server_ends_the_command_of_its_client(lab: gecos.Lab) -> None:
    server = start(SERVING)
    assert server.stdout is not None
    assert server.stdout.readline() == "serving LAMP\n"
    lamp = lab.create(Lamp, "LAMP", medium="shm")
    with gecos.actor(lamp):
        burning = lamp.burn_in()
        while burning.progress().fraction < 0.25:
            burning.wait(0.001)
        server.kill()
        assert burning.wait() is gecos.State.COMMAND_FAILED
        assert burning.progress().detail is gecos.Detail.SERVER_CRASHED
        assert lamp.label().wait() is gecos.State.CONNECTION_FAILED
    server.communicate(timeout=30)


def test_importing_the_codec_needs_neither_extension_nor_numpy() -> None:
    program = (
        "import sys, gecos.wire, gecos.errors; "
        "print(*sorted({'gecos._core', 'numpy', 'asyncio', 'typer', 'rich'} & set(sys.modules)))"
    )
    client = start(program)
    out, err = client.communicate(timeout=30)
    assert out.strip() == "", err
