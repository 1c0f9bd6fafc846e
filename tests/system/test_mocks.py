"""Servers as `gidl new --mock` writes them, in both languages, called by a client."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import gecos
import pytest
from processes import Laboratory, Program
from robcl.frames import Frame
from robcl.laser_distance_sensor import LaserDistanceSensor
from robcl.manipulator_types import Configuration
from robcl.rx90 import Rx90
from robcl.six_axis_types import Joints

TREE = Path(__file__).resolve().parents[2]
ROOTS = ("tests/idl/workshop", "tests/idl", "idl")
SEARCH = [word for root in ROOTS for word in ("-I", str(TREE / root))]
FILES = {
    "laser": "idl/robcl/laser_distance_sensor.gidl",
    "rx90": "idl/robcl/rx90.gidl",
    "everything": "tests/idl/everything.gidl",
    "workshop": "tests/idl/workshop/workshop.gidl",
}

Mock = Callable[[str], Program]


def gidl(*words: str | Path) -> None:
    command = [sys.executable, "-m", "gidl", *map(str, words)]
    subprocess.run(command, check=True, cwd=TREE, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="session")
def mocks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a mock of each in Python, and the Python that the tests' interfaces need."""
    folder = tmp_path_factory.mktemp("mocks")
    own = [FILES["everything"], FILES["workshop"]]
    gidl("gen", "--lang", "python", *SEARCH, "--out", folder, *own)
    for name, file in FILES.items():
        gidl("new", "--mock", file, "--lang", "python", *SEARCH, "--into", folder / name)
    sys.path.insert(0, str(folder / "python"))
    yield folder
    sys.path.remove(str(folder / "python"))


@pytest.fixture(params=["C++", "Python"])
def mock(
    request: pytest.FixtureRequest, mocks: Path, lab_with_broker: Laboratory, here: None
) -> Mock:
    """Starts the mock of one of the files and waits until it serves."""
    lab = lab_with_broker
    path = os.pathsep.join(filter(None, [str(mocks / "python"), lab.env.get("PYTHONPATH", "")]))
    lab.env["PYTHONPATH"] = path

    def start(name: str) -> Program:
        if request.param == "C++":
            command: list[str | Path] = [lab.build / "tests" / "cpp" / "mocks" / f"mock_{name}"]
        else:
            command = [sys.executable, mocks / name / "server.py"]
        return lab.start(*command, ready="serving")

    return start


@pytest.fixture
def client() -> Iterator[gecos.Lab]:
    with gecos.Lab() as lab:
        yield lab


def holds_its_rate(attribute: gecos.StreamAttribute[Any], rate_hz: float, count: int = 30) -> None:
    """Checks the stamps, which are the due times: each is a whole number of periods after the one
    before it, and exactly one period at least once. The delay of a sample is not checked."""
    period = 1.0 / rate_hz
    samples = []
    stream = attribute.stream()
    for _ in range(count):
        samples.append(stream.next(timeout=30.0))
    stream.close()
    gaps = [b.stamp - a.stamp for a, b in pairwise(samples)]
    beats = [round(gap / period) for gap in gaps]
    assert all(abs(gap - n * period) < 2e-6 for gap, n in zip(gaps, beats, strict=True)), gaps
    assert min(beats) == 1, gaps
    for (before, after), n in zip(pairwise(samples), beats, strict=True):
        assert 1 <= after.sequence - before.sequence <= n, "more samples than beats"


def test_a_laser_is_read_switched_and_heard(mock: Mock, client: gecos.Lab) -> None:
    served = mock("laser")
    laser = client.create(LaserDistanceSensor, "LASER_DISTANCE_SENSOR")
    assert laser.measure().result() == laser.beam().result()
    with pytest.raises(gecos.CommandFailed, match="DENIED"):
        laser.power(True).result()
    with gecos.actor(laser):
        laser.power(True).result()
        laser.mount("RX90", Frame((1.0, 2.0, 3.0))).result()
    assert "LASER_DISTANCE_SENSOR: power" in served.wait_for("power")
    assert "RX90" in served.wait_for("mount")
    holds_its_rate(laser.beam, 50.0)


def test_an_arm_moves_at_once_and_keeps_what_is_set(mock: Mock, client: gecos.Lab) -> None:
    served = mock("rx90")
    arm = client.create(Rx90, "RX90")
    assert arm.posture().result() == Configuration()
    offset = Frame((0.0, 0.0, 0.125))
    with gecos.actor(arm):
        arm.set_tool_offset(offset).result()
        move = arm.move(Frame((0.5, 0.0, 0.5)))
        move.result()
        assert 0.0 <= move.feedback().fraction <= 1.0
        arm.move_joints(Joints()).result()
    assert arm.tool_offset().result() == offset
    assert served.wait_for("move").startswith("RX90: move")
    holds_its_rate(arm.joints, 250.0)


def test_one_of_everything_answers(mock: Mock, client: gecos.Lab, mocks: Path) -> None:
    mock("everything")
    types, calls = import_module("everything_types"), import_module("everything")
    stage = client.create(calls.Stage, "STAGE")
    deep = client.create(calls.Deep, "DEEP")
    assert stage.level().result() == 2.5
    with gecos.actor(stage):
        stage.set_level(4.0).result()
        assert stage.paint(types.Colour.RED, ["a"], 2).result() is types.Colour.GREEN
    assert stage.level().result() == 4.0
    assert deep.level().result() == 2.5, "objects have values of their own"
    measured = stage.measure(1, types.Grows(first=7)).result()
    assert measured == types.Stage_measure_result(0.0, "", types.Grows(first=7))
    with gecos.actor(deep):
        deep.register(1, 2, 3).result()
    holds_its_rate(stage.samples, 10.0, count=8)


def test_answers_lie_within_their_ranges(mock: Mock, client: gecos.Lab, mocks: Path) -> None:
    mock("workshop")
    types, calls = import_module("workshop_types"), import_module("workshop")
    worn = types.Wear(share=0.5, times=1, balance=-2, seat=types.Fit.LOOSE, grade=12, spare=None)
    tool = client.create(calls.Tool, "TOOL")
    assert tool.state().result() == worn
    assert tool.weight().result() == 1.0

    changer = client.create(calls.Changer, "CHANGER")
    assert changer.angle().result() == -20
    assert changer.look().result() == types.Finding(types.Fit.LOOSE, worn)
    assert changer.seat().result() is types.Fit.LOOSE
    assert changer.name().result() == []
    assert changer.pull(worn).result() == 5.0
    seen = changer.inspect().result()
    assert seen.worst == worn and seen.both_ends == [worn, worn]
    assert seen.pulls.tolist() == [[5.0] * 3] * 2


def test_describe_shows_the_enumerator_of_a_reading(
    mock: Mock, lab_with_broker: Laboratory
) -> None:
    mock("workshop")
    described = lab_with_broker.run(sys.executable, "-m", "gecos.cli", "describe", "CHANGER")
    assert "  seat: workshop::Fit = LOOSE" in described.lines
    as_json = lab_with_broker.run(*described.command, "--json")
    assert json.loads(as_json.output())["readings"]["seat"] == "LOOSE"


def test_what_is_set_is_what_is_got_and_published(
    mock: Mock, client: gecos.Lab, mocks: Path
) -> None:
    served = mock("workshop")
    types, calls = import_module("workshop_types"), import_module("workshop")
    changer = client.create(calls.Changer, "CHANGER")
    tool = gecos.reference(client.create(calls.Tool, "TOOL"))
    with gecos.actor(changer):
        changer.set_angle(-11).result()
        changer.set_last(tool).result()
        turn = changer.turn(1.0, "open sesame")
        turn.result()
        assert turn.feedback() == types.Turning(turns=5.0)
        changer.park().result()
    stream = changer.angle.stream()
    while stream.next(timeout=30.0).value != -11:
        pass
    assert client.create(calls.Tool, changer.last().result()).weight().result() == 1.0
    served.wait_for("park")
    assert "open sesame" not in served.output(), "what is @secret is not printed"
    assert "***" in served.output()


def test_a_mock_ends_like_any_server(mock: Mock) -> None:
    assert mock("rx90").terminate() == 0
