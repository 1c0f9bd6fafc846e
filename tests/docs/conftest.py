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
    """Somebody at the terminals of one machine, in the folder of robcl."""
    env = variables(place / "home")
    with Reader(lambda name: Terminal(env, TREE, hosts.on(0))) as reader:
        yield reader
