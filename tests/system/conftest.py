"""A laboratory of processes per test, and the Python of the tests' own interface."""

from __future__ import annotations

import atexit
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import Laboratory, laboratory

TREE = Path(__file__).resolve().parents[2]

# Programs inherit that a signal is ignored. Under nohup, SIGHUP is, and it would end none of them.
signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture(scope="session")
def build() -> Path:
    folder = TREE / os.environ.get("GECOS_BUILD", "build")
    assert (folder / "CMakeCache.txt").exists(), f"{folder} is empty: run `make build-tests`"
    return folder


def _generate_python(root: Path, interface: str, out: Path) -> None:
    """Makes the Python of an interface in `root` importable, here and in programs that are
    started."""
    words = ["--lang", "python", "-I", root, "-I", TREE / "idl", "--out", out]
    subprocess.run(
        [sys.executable, "-m", "gidl", "gen", *words, root / interface],
        check=True,
        stdout=subprocess.DEVNULL,
    )


_generated = tempfile.TemporaryDirectory(prefix="rail-")
atexit.register(_generated.cleanup)
_out = Path(_generated.name)  # now: test modules import from it when they are collected
_generate_python(TREE / "tests" / "system" / "rail", "lab/rail_sensor.gidl", _out)
_generate_python(TREE / "tests" / "idl" / "inward", "feeder.gidl", _out)
_generate_python(TREE / "tests" / "idl" / "events", "button.gidl", _out)
_generate_python(TREE / "tests" / "idl" / "open", "barograph.gidl", _out)
sys.path.insert(0, str(_out / "python"))
_before = os.environ.get("PYTHONPATH")
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(_out / "python"), _before]))


@pytest.fixture(scope="session")
def place() -> Iterator[Path]:
    """Where the laboratories meet: one folder for the process's life, because it is what a process
    takes for its host. tests/python may have chosen it already."""
    chosen = os.environ.get("GECOS_RUNTIME_DIR")
    if chosen:
        yield Path(chosen)
        return
    # Not tmp_path: the name of a Unix socket has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="gecos-") as directory:
        yield Path(directory)


@pytest.fixture
def lab(build: Path, place: Path) -> Iterator[Laboratory]:
    yield from laboratory(place, build)


@pytest.fixture
def fast_clock(lab: Laboratory) -> None:
    """For tests that wait for motions and promise nothing about real time."""
    lab.env["ROBCL_CLOCK"] = "10"


@pytest.fixture
def lab_with_broker(lab: Laboratory) -> Laboratory:
    lab.start(lab.build / "runtime" / "cpp" / "gecos" / "broker" / "gecos-broker", ready="ready")
    return lab


@pytest.fixture
def here(lab: Laboratory, monkeypatch: pytest.MonkeyPatch) -> None:
    """This process is a client of the test's laboratory too."""
    monkeypatch.setenv("GECOS_RUNTIME_DIR", lab.env["GECOS_RUNTIME_DIR"])
    monkeypatch.delenv("GECOS_BROKER", raising=False)


@pytest.fixture
def lab_with_arm(lab_with_broker: Laboratory) -> Laboratory:
    lab_with_broker.start(lab_with_broker.build / "devices/rx90/robcl-rx90", ready="ready")
    return lab_with_broker


@pytest.fixture
def lab_with_devices(lab_with_broker: Laboratory) -> Laboratory:
    lab = lab_with_broker
    for device in ("world/robcl-world", "rx90/robcl-rx90", "gripper/robcl-gripper"):
        lab.start(lab.build / "devices" / device, ready="ready")
    lab.start(lab.build / "devices" / "laser_distance_sensor" / "robcl-lds", ready="ready")
    return lab
