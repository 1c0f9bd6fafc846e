"""The commands of docs/command-line.md, and its Python, in the simulated laboratory."""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
from pathlib import Path

import pytest
from gecos.laboratory import read_laboratory
from processes import Laboratory, until

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "command-line.md").read_text()
COMMANDS = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)[0].splitlines()
GECOS = [sys.executable, "-m", "gecos.cli"]
HOLD = Path(__file__).parent / "programs" / "hold.py"


def test_every_command_of_the_page_does_its_work(lab_with_devices: Laboratory) -> None:
    for line in COMMANDS:
        words = shlex.split(line)[1:]
        done = lab_with_devices.run(*GECOS, *words)
        assert done.finish() == 0, f"{line}: {done}"
        assert done.output(), line


def test_a_served_arm_in_cpp_is_described_whole(lab_with_devices: Laboratory) -> None:
    done = lab_with_devices.run(*GECOS, "describe", "RX90", "--json")
    assert done.finish() == 0, str(done)
    shown = json.loads(done.output())
    assert shown["interface_name"] == "robcl::Rx90"
    assert shown["readings"]["braking_time"] == pytest.approx(1 / 3 + 2 * 0.032)  # s, by rx90.toml
    names = {model["interface"]["name"] for model in shown["models"]}
    assert names == {"robcl::Rx90", "robcl::SixAxis", "robcl::Manipulator", "robcl::Device"}


def test_the_python_of_the_page_runs(lab_with_devices: Laboratory) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    done = lab_with_devices.run(sys.executable, "-c", program)
    assert done.finish() == 0, str(done)
    assert 0 < float(done.output()) < 0.2


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["call", "GRIPPER", "open", "width=-1"], 2),
        (["call", "GRIPPER", "open", "width=9"], 3),
        (["get", "NOBODY", "tool"], 4),
    ],
)
def test_the_exit_code_says_how_it_ended(
    words: list[str], code: int, lab_with_devices: Laboratory
) -> None:
    done = lab_with_devices.run(*GECOS, *words)
    assert done.finish() == code, str(done)


def test_an_arm_that_another_program_moves_ends_with_5(lab_with_devices: Laboratory) -> None:
    holder = "import gecos; lab = gecos.Lab(); lease = gecos.master(lab.dynamic('RX90'))\n"
    holder += "with lease: print('holds', flush=True); input()"
    lab_with_devices.start(sys.executable, "-c", holder, ready="holds", listens=True)
    offset = '{"position": {"z": 0.1}}'
    done = lab_with_devices.run(*GECOS, "set", "RX90", "tool_offset", offset)
    assert done.finish() == 5, str(done)


def test_a_refusal_is_explained_from_the_audit_which_has_no_password(
    lab_with_devices: Laboratory,
) -> None:
    holder = "import gecos; lab = gecos.Lab()\n"
    holder += "with gecos.actor(lab.dynamic('RX90'), 's3cret'): print('holds', flush=True); input()"
    lab_with_devices.start(sys.executable, "-c", holder, ready="holds", listens=True)
    offset = '{"position": {"z": 0.1}}'
    words = ["set", "RX90", "tool_offset", offset, "--password", "s3cret-guess"]
    refused = lab_with_devices.run(*GECOS, *words)
    assert refused.finish() == 5, str(refused)
    (number,) = re.findall(r"\(request (\S+)\)", refused.output())

    def explained() -> bool:
        why = lab_with_devices.run(*GECOS, "why", number)
        return why.finish() == 0 and "is refused ACTOR status: " in why.output()

    until(explained, "a line about the refusal")
    files = list(Path(os.environ["GECOS_AUDIT_DIR"]).iterdir())
    assert "RX90" in "".join(file.read_text() for file in files)
    assert not [file for file in files if "s3cret" in file.read_text()]


@pytest.mark.parametrize("words", [["RX90"], ["--all"]])
def test_an_arm_is_stopped_after_the_death_of_the_broker(
    words: list[str], lab_with_arm: Laboratory
) -> None:
    broker = lab_with_arm.programs[0]
    mover = lab_with_arm.start(sys.executable, HOLD, ready="moving")
    broker.kill()
    stopped = lab_with_arm.run(*GECOS, "stop", *words)
    assert "RX90: stopped" in stopped.lines
    assert "ended COMMAND_FAILED/STOPPED: " in mover.wait_for("ended")
    knows_all = words == ["RX90"]
    assert stopped.finish() == (0 if knows_all else 4), str(stopped)
    assert ("the broker did not say which other objects" in stopped.output()) is not knows_all


def test_the_laboratory_of_the_page_is_read(tmp_path: Path) -> None:
    texts = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (text,) = (text for text in texts if "[programs." in text)
    (tmp_path / "lab.toml").write_text(text)
    found = read_laboratory(tmp_path / "lab.toml")
    assert [program.name for program in found.programs] == ["WORLD", "GRIPPER", "THERMOMETER"]
    assert found.starts_broker
