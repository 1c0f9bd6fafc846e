import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from blocks import blocks, run
from pages import TREE, Reader, variables
from terminals import Terminal

sys.path.append(str(TREE / "tests" / "stress"))  # hosts.py

from hosts import Hosts

STAND_INS = Path(__file__).parent / "stand_ins"


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What gidl makes of the README's interface."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "oven.gidl").write_text(blocks("README.md", "idl")[0])
    command = [sys.executable, "-m", "gidl", "gen", "-I", folder, "--out", folder / "out"]
    run(*command, folder / "oven.gidl")
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


@pytest.fixture
def reader(hosts: Hosts, place: Path) -> Iterator[Reader]:
    """Somebody at the terminals of one machine, or of two, in the folder of robcl on each."""
    shutil.copytree(STAND_INS, place / "bin")
    machines: dict[str, tuple[dict[str, str], list[str]]] = {}

    def open_terminal(host: str) -> Terminal:
        if host not in machines:
            env = variables(place / (host or "home"), place / "bin")
            machines[host] = env, hosts.on(len(machines))
        env, within = machines[host]
        return Terminal(env, TREE, within)

    with Reader(open_terminal) as reader:
        yield reader
