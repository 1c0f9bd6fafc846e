"""Fixtures: the programs of the stress tests, and the generated Python of their interface."""

from __future__ import annotations

import atexit
import os
import random
import sys
import tempfile
from pathlib import Path

import pytest
import rampage

_generated = tempfile.TemporaryDirectory(prefix="workbench-")
atexit.register(_generated.cleanup)
TREE = Path(__file__).resolve().parents[2]
# Generated before the tests are collected, because test modules import the generated code.
rampage.generate_python(Path(_generated.name))
rampage.generate_python(Path(_generated.name), TREE / "tests/idl/inward/feeder.gidl")
sys.path.insert(0, f"{_generated.name}/python")


@pytest.fixture(scope="session")
def build() -> Path:
    folder = TREE / os.environ.get("GECOS_BUILD", "build")
    assert (folder / "tests" / "stress" / "stress_client").exists(), (
        f"the programs of the stress tests are not built in {folder}: run `make build-tests`"
    )
    return folder


@pytest.fixture(scope="session")
def env(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the programs find beside their own: the Python of the workbench, keys of this run."""
    before = os.environ.get("PYTHONPATH")
    keys = tmp_path_factory.mktemp("keys")
    return {
        "PYTHONPATH": os.pathsep.join(filter(None, [f"{_generated.name}/python", before])),
        "GECOS_KEY_DIR": str(keys),
        "GECOS_AUDIT_DIR": str(tmp_path_factory.mktemp("audit")),
    }


@pytest.fixture
def seed() -> int:
    """Stands in the plan that is printed; STRESS_SEED repeats a run with it."""
    return int(os.environ.get("STRESS_SEED") or random.randrange(1 << 30))
