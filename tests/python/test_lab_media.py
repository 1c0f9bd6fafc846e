"""Where the lab file says which media are real-time, HARD_REALTIME goes by it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gecos
import pytest
from command_output import Run, valid
from generated_module import imported

INTERFACE = """#pragma once

module drives {
  @qos(class=HARD_REALTIME)
  interface Drive {
    @sensor double torque();
  };
};
"""
LCM_IS = "[media.lcm]\nreal_time = true\n"
SHM_IS_NOT = "[media.shm]\nreal_time = false\n"

Write = Callable[[str], Path]


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The generated module of INTERFACE."""
    out = tmp_path_factory.mktemp("drives")
    source = out / "drives.gidl"
    source.write_text(INTERFACE)
    with imported("drives", source, out, out) as module:
        yield module


@pytest.fixture
def served(lab: gecos.Lab, drives: Any) -> Iterator[None]:
    """A drive that is no simulation."""

    class Drive(drives.DriveServant):  # type: ignore[misc]
        def torque(self) -> float:
            return 2.0

    with gecos.Server(lab) as server:
        server.add("DRIVE", Drive())
        yield


@pytest.fixture
def write(served: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Writes the lab file of the clients that are made from now on."""
    file = tmp_path / "lab.toml"
    monkeypatch.setenv("GECOS_LAB_FILE", str(file))

    def written(text: str) -> Path:
        file.write_text(text)
        os.utime(file, (0, 0))  # a file counts when it has not changed for a while
        return file

    return written


@pytest.fixture
def client(write: Write) -> Iterator[gecos.Lab]:
    write("")
    with gecos.Lab() as lab:
        yield lab


def why_not(client: gecos.Lab, drives: Any, medium: str) -> str:
    with pytest.raises(gecos.CreateError) as refused:
        client.create(drives.Drive, "DRIVE", medium=medium)
    return str(refused.value)


def test_hard_real_time_goes_over_lcm_if_the_lab_file_calls_it_real_time(
    client: gecos.Lab, write: Write, drives: Any
) -> None:
    own_word = "class=HARD_REALTIME: the medium lcm shares a queue with other programs"
    assert own_word in why_not(client, drives, "lcm")
    write(LCM_IS)
    assert client.create(drives.Drive, "DRIVE", medium="lcm").torque().result() == 2.0


def test_hard_real_time_does_not_go_over_shm_if_the_lab_file_says_that_it_is_not_real_time(
    client: gecos.Lab, write: Write, drives: Any
) -> None:
    assert client.create(drives.Drive, "DRIVE", medium="shm").torque().result() == 2.0
    file = write(SHM_IS_NOT)
    rule = f"class=HARD_REALTIME: [media.shm] in {file}:2 says that shm is not real-time"
    assert rule in why_not(client, drives, "shm")


def test_gecos_explain_says_what_the_lab_file_states_and_where(write: Write, run: Run) -> None:
    write("")
    code, out, _ = run("explain", "DRIVE")
    assert code == 0
    assert "says that" not in out
    file = write(LCM_IS + SHM_IS_NOT)
    lcm = f"[media.lcm] in {file}:2 says that lcm is real-time"
    shm = f"class=HARD_REALTIME: [media.shm] in {file}:4 says that shm is not real-time"
    code, out, _ = run("explain", "DRIVE")
    assert code == 0
    assert f"  lcm: used if no medium above it answers\n    {lcm}\n" in out
    assert f"  shm: {shm}\n" in out
    code, out, _ = run("explain", "DRIVE", "--json")
    assert (code, valid(out, "explain")) == (0, True)
    told = {each["medium"]: each for each in json.loads(out)["media"]}
    assert (told["lcm"]["suitable"], told["lcm"]["real_time_by"]) == (True, lcm)
    assert (told["shm"]["suitable"], told["shm"]["real_time_by"]) == (False, "")
    assert told["shm"]["reason"] == shm


def test_gecos_explain_says_that_the_lab_file_has_an_error(write: Write, run: Run) -> None:
    file = write("[media.lcm]\nrealtime = true\n")
    code, out, _ = run("explain", "DRIVE")
    assert code == 0
    error = f"{file}:2: media.lcm.realtime: this key is unknown; did you mean real_time?"
    assert out.count(error) == 3, "it holds for each medium"
