import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest
from blocks import blocks, run
from pages import TREE, Reader, variables
from terminals import Terminal

sys.path += [str(TREE / "tests" / "stress"), str(TREE / "tests" / "system")]

from course import STAND_INS, Course
from hosts import Hosts
from without_tree import without_tree


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What gidl makes of the README's interface, and of the camera in docs/programs.md."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "oven.gidl").write_text(blocks("README.md", "idl")[0])
    (camera,) = (block for block in blocks("docs/programs.md", "idl") if "Camera" in block)
    (folder / "camera.gidl").write_text(camera)
    command = [sys.executable, "-m", "gidl", "gen", "-I", folder, "--out", folder / "out"]
    run(*command, folder / "oven.gidl", folder / "camera.gidl")
    return folder / "out"


@pytest.fixture
def hosts() -> Iterator[Hosts]:
    with Hosts() as hosts:
        yield hosts


@pytest.fixture
def place() -> Iterator[Path]:
    """Not tmp_path: the name of a Unix socket has at most 107 characters."""
    with tempfile.TemporaryDirectory(prefix="pages-") as folder:
        yield Path(folder)


@dataclass(frozen=True, slots=True)
class Machine:
    """Where terminals are opened. `within`: words in front of a command that runs there."""

    env: dict[str, str]
    folder: Path
    within: Sequence[str | Path]

    def terminal(self) -> Terminal:
        return Terminal(self.env, self.folder, list(map(str, self.within)))


@pytest.fixture
def machines(place: Path) -> dict[str, Machine]:
    """By their names; a page with one machine gives it none."""
    shutil.copytree(STAND_INS, place / "bin")
    return {}


@pytest.fixture
def cell(machines: dict[str, Machine], hosts: Hosts, place: Path) -> Iterator[Machine]:
    """A machine without the tree, with folders of its own for what an administrator writes. Its
    services run by tests/docs/service_manager.py."""
    env = variables(place / "cell", place / "bin")
    del env["GECOS_RUNTIME_DIR"]  # as for services: programs meet in /run
    packages = Path(sysconfig.get_path("purelib", "posix_user", {"userbase": str(place / "base")}))
    for folder in (packages, place / "borrowed", *(place / name for name in ("opt", "run", "lib"))):
        folder.mkdir(parents=True)
    (packages / "borrowed.pth").write_text(f"{place}/borrowed\n")  # what apt-get would install
    subprocess.run(["cp", "-a", "/etc", place / "etc"], stderr=subprocess.DEVNULL)
    manager = shutil.copy(Path(__file__).parent / "service_manager.py", place)
    system = f"{sys.base_prefix}/bin:/usr/sbin:/usr/bin:/sbin:/bin"
    env |= {"PYTHONUSERBASE": str(place / "base"), "PATH": f"{place}/bin:{system}"}
    also = {"/opt": place / "opt", "/etc": place / "etc", "/run": place / "run"}
    also["/var/lib"] = place / "lib"
    alone = ("unshare", "-mu", "sh", "-euc", 'hostname cell; exec "$@"', "sh")
    bare = without_tree(place / "borrowed", also, alone)
    machines["cell"] = machine = Machine(env, place / "cell", (*hosts.on(0), *bare))
    with subprocess.Popen(
        [*machine.within, "python3", manager],
        env=env,
        cwd=machine.folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as running:
        assert running.stdout is not None
        assert running.stdout.readline() == b"ready\n"
        yield machine
        running.communicate()  # the end of its input is the end of it


@pytest.fixture
def reader(machines: dict[str, Machine], hosts: Hosts, place: Path) -> Iterator[Reader]:
    """Somebody at the terminals of one machine, or of two, in the folder of robcl on each."""

    def open_terminal(host: str) -> Terminal:
        if host not in machines:
            env = variables(place / (host or "home"), place / "bin")
            machines[host] = Machine(env, TREE, hosts.on(len(machines)))
        return machines[host].terminal()

    with Reader(open_terminal) as reader:
        yield reader


@pytest.fixture(scope="module")
def course(pytestconfig: pytest.Config) -> Iterator[Course]:
    terminal = pytestconfig.pluginmanager.get_plugin("terminalreporter")
    assert terminal is not None
    with closing(Course(terminal.write_line)) as course:
        yield course
