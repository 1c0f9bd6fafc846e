import sys
from pathlib import Path

import pytest
from blocks import blocks, run


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What gidl makes of the README's interface."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "oven.gidl").write_text(blocks("README.md", "idl")[0])
    command = [sys.executable, "-m", "gidl", "gen", "-I", folder, "--out", folder / "out"]
    run(*command, folder / "oven.gidl")
    return folder / "out"
