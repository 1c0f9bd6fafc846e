"""What only a process of its own can show: signals, and the end of a program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import gecos
import pytest
from lamp import Lamp, PlainLamp

HERE = Path(__file__).resolve().parent


@contextmanager
def running(program: str) -> Iterator[subprocess.Popen[str]]:
    """A Python process of its own; it is gone after the block, whatever happened in it."""
    path = [str(HERE), *sys.path]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, path))}
    with subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def says(process: subprocess.Popen[str]) -> str:
    """Its next line."""
    assert process.stdout is not None
    return process.stdout.readline()


WAITING = """
import gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="shm")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
try:
    print("waiting", flush=True)
    burning.wait()
except KeyboardInterrupt:
    print("interrupted", burning.state.name, flush=True)
    burning.cancel()
"""


def test_ctrl_c_ends_a_wait(server: gecos.Server, servant: PlainLamp) -> None:
    with running(WAITING) as client:
        assert says(client) == "waiting\n"
        servant.burning.wait()
        client.send_signal(signal.SIGINT)
        out, err = client.communicate(timeout=30)
        assert (out, client.returncode) == ("interrupted RUNNING\n", 0), err


LEAVING = """
import gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="{medium}")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.detach()
lamp.dim(2.0).detach()
"""


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_what_was_issued_runs_on_after_the_program_has_ended(
    lab: gecos.Lab, server: gecos.Server, servant: PlainLamp, medium: str
) -> None:
    servant.value = 8.0
    with running(LEAVING.format(medium=medium)) as client:
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
    with running(KILLED) as client:
        assert says(client) == "moving\n"
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
    with running(SERVING) as server:
        assert says(server) == "serving LAMP\n"
        lamp = lab.create(Lamp, "LAMP")
        assert lamp.label().result() == "a lamp"
        server.send_signal(signal.SIGTERM)
        out, err = server.communicate(timeout=30)
        assert (out, server.returncode) == ("left\n", 0), err


def test_a_killed_server_ends_the_command_of_its_client(lab: gecos.Lab) -> None:
    with running(SERVING) as server:
        assert says(server) == "serving LAMP\n"
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
        "print(*sorted({'gecos._core', 'numpy', 'asyncio', 'click', 'rich'} & set(sys.modules)))"
    )
    with running(program) as client:
        out, err = client.communicate(timeout=30)
        assert out.strip() == "", err


WITH_FEW_DESCRIPTORS = (
    """
import resource
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
"""
    + SERVING
)


def test_a_server_without_descriptors_tells_the_client_so_and_serves_the_others(
    lab: gecos.Lab,
) -> None:
    with running(WITH_FEW_DESCRIPTORS) as server:
        assert says(server) == "serving LAMP\n"
        first = lab.create(Lamp, "LAMP", medium="shm")
        others = gecos.Lab()
        let_in = []
        with pytest.raises(
            gecos.CreateError, match=r"accept the connection: .*(ulimit -n|Too many open files)"
        ):
            for _ in range(64):
                let_in.append(others.create(Lamp, "LAMP", medium="shm"))
        assert first.label().result(30) == "a lamp"
        others.close()
        while True:  # the server learns of it at its own pace
            try:
                again = lab.create(Lamp, "LAMP", medium="shm")
            except gecos.CreateError:
                continue
            break
        assert again.label().result(30) == "a lamp"


READING_WITHOUT_DESCRIPTORS = """
import os, resource, gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="{medium}")
lamp.label().result()
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
while True:  # again if a thread had a file open for a moment, whose descriptor is free now
    try:
        while True: os.open("/dev/null", os.O_RDONLY)
    except OSError:
        pass
    try:
        lamp.level.stream().close()
    except gecos.ConnectionFailed as error:
        print(error, flush=True)
        break
print(lamp.label().result(30), flush=True)
"""


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_a_stream_for_which_no_descriptor_is_left_is_refused_with_the_reason(
    server: gecos.Server, medium: str
) -> None:
    with running(READING_WITHOUT_DESCRIPTORS.format(medium=medium)) as client:
        said = says(client)
        assert said.startswith(
            "REFUSED: LAMP.level: stream 'level' of LAMP cannot be opened in this"
        )
        assert "Too many open files (see `ulimit -n` and" in said
        assert says(client) == "a lamp\n", client.communicate()[1]


CREATING_WITH_FEW_DESCRIPTORS = """
import errno, resource, gecos
from lamp import Lamp
resource.setrlimit(resource.RLIMIT_NOFILE, (40, 40))
lamps, labs = [], []
try:
    while True: lamps.append(gecos.Lab().create(Lamp, "LAMP", medium="shm"))
except gecos.CreateError as error:
    print(error, flush=True)
try:
    while True: labs.append(gecos.Lab())
except OSError as error:
    print(error, flush=True)
    assert error.errno == errno.EMFILE
print(lamps[0].label().result(30), flush=True)
"""


def test_a_client_without_descriptors_says_so_and_goes_on_with_what_it_has(
    server: gecos.Server,
) -> None:
    with running(CREATING_WITH_FEW_DESCRIPTORS) as client:
        for said in (says(client), says(client)):
            assert "Too many open files" in said and "see `ulimit -n`" in said
        assert says(client) == "a lamp\n", client.communicate()[1]
