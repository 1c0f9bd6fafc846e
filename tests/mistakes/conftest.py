"""One laboratory for all mistakes that are made in this process: a broker, two grippers, a laser
and a simulated arm, which is a program of its own."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gecos
import numpy as np
import pytest
import robcl.frames
from laboratory import Jaws, Laser
from mistakes import TREE
from robcl.gripper import Gripper, GripperState
from robcl.laser_distance_sensor import LaserDistanceSensor
from robcl.rx90 import Rx90
from robcl.six_axis_types import Joints


@pytest.fixture(scope="session")
def build() -> Path:
    folder = TREE / os.environ.get("GECOS_BUILD", "build")
    assert (folder / "CMakeCache.txt").exists(), f"{folder} is empty: run `make build-tests`"
    return folder


@pytest.fixture(scope="session")
def place() -> Iterator[Path]:
    """The runtime folder of this process. Other tests may have chosen it already."""
    chosen = os.environ.get("GECOS_RUNTIME_DIR")
    if chosen:
        yield Path(chosen)
        return
    with (
        tempfile.TemporaryDirectory(prefix="gecos-") as folder,
        pytest.MonkeyPatch.context() as environment,
    ):
        environment.setenv("GECOS_RUNTIME_DIR", folder)
        environment.delenv("GECOS_BROKER", raising=False)
        yield Path(folder)


@pytest.fixture(scope="module")
def arm(laboratory: gecos.Lab, build: Path) -> Iterator[Rx90]:
    words = [build / "devices" / "rx90" / "robcl-rx90"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert "ready" in program.stdout.readline()
        try:
            yield laboratory.create(Rx90, "RX90")
        finally:
            program.terminate()


@pytest.fixture(scope="module")
def laboratory(place: Path) -> Iterator[gecos.Lab]:
    with gecos.Lab() as lab, gecos.Broker(lab), gecos.Server(lab) as server:
        server.add("GRIPPER", Jaws(), simulated=True)
        server.add("HELD", Jaws(), simulated=True)
        server.add("LASER", Laser(), simulated=True)
        with gecos.Lab() as other, gecos.master(other.create(Gripper, "HELD")):
            yield lab


@pytest.fixture
def names(laboratory: gecos.Lab, arm: Rx90) -> dict[str, Any]:
    """What the code of a mistake may use."""
    return {
        "gecos": gecos,
        "np": np,
        "lab": laboratory,
        "arm": arm,
        "gripper": laboratory.create(Gripper, "GRIPPER"),
        "held": laboratory.create(Gripper, "HELD"),
        "laser": laboratory.create(LaserDistanceSensor, "LASER"),
        "Gripper": Gripper,
        "GripperState": GripperState,
        "LaserDistanceSensor": LaserDistanceSensor,
        "Jaws": Jaws,
        "Joints": Joints,
        "frames": robcl.frames,
    }
