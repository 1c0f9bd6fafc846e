import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def reading() -> Iterator[Reader]:
    """Somebody at the terminals of one machine, in the folder of robcl."""
    # Not tmp_path: the name of a Unix socket has at most 107 characters.
    with Hosts() as hosts, tempfile.TemporaryDirectory(prefix="pages-") as folder:
        env = variables(Path(folder) / "home")
        with Reader(lambda name: Terminal(env, TREE, hosts.on(0))) as reader:
            yield reader


@pytest.fixture
def reader() -> Iterator[Reader]:
    with reading() as reader:
        yield reader


@pytest.fixture(scope="module")
def student() -> Iterator[Reader]:
    """Follows several pages in the same laboratory, which runs on from page to page."""
    with reading() as reader:
        yield reader
