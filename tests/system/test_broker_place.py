"""The broker that a lab file names, as the commands find it."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import Laboratory

GECOS = [sys.executable, "-m", "gecos.cli"]


def write(file: Path, text: str, mode: int = 0o644) -> None:
    file.write_text(text)
    file.chmod(mode)


@pytest.fixture
def address(lab_with_broker: Laboratory) -> str:
    return f"shm:{lab_with_broker.env['GECOS_RUNTIME_DIR']}/BROKER.sock"


@pytest.fixture
def file(lab_with_broker: Laboratory, address: str, tmp_path: Path) -> Iterator[Path]:
    """The lab file of the programs that are started from now on, which names the broker. They have
    a runtime directory of their own, so nothing else leads them to it."""
    file = tmp_path / "lab.toml"
    write(file, f'[broker]\naddress = "{address}"\n')
    with tempfile.TemporaryDirectory(prefix="gecos-") as directory:
        lab_with_broker.env |= {"GECOS_RUNTIME_DIR": directory, "GECOS_LAB_FILE": str(file)}
        yield file


def test_commands_find_the_broker_that_the_lab_file_names(
    lab_with_broker: Laboratory, file: Path
) -> None:
    ls = lab_with_broker.run(*GECOS, "ls")
    assert ls.finish() == 0, str(ls)


def test_the_variable_comes_before_the_lab_file_and_the_option_before_both(
    lab_with_broker: Laboratory, file: Path, address: str
) -> None:
    lab_with_broker.env["GECOS_BROKER"] = "shm"
    ls = lab_with_broker.run(*GECOS, "ls")
    assert ls.finish() == 4, str(ls)
    assert address not in ls.output()
    ls = lab_with_broker.run(*GECOS, "ls", "--broker", address)
    assert ls.finish() == 0, str(ls)
    write(file, '[broker]\naddress = "inproc:nobody"\n')
    ls = lab_with_broker.run(*GECOS, "ls", "--broker", address)
    assert ls.finish() == 0, str(ls)


def test_a_lab_file_that_others_may_write_leads_to_no_broker(
    lab_with_broker: Laboratory, file: Path
) -> None:
    file.chmod(0o666)
    ls = lab_with_broker.run(*GECOS, "ls")
    assert ls.finish() == 4, str(ls)
    assert f"{file}: other users may write to the file" in ls.output()
    assert "no broker answers" not in ls.output()


def test_the_doctor_says_where_the_broker_is_named(
    lab_with_broker: Laboratory, file: Path, address: str
) -> None:
    doctor = lab_with_broker.run(*GECOS, "doctor")
    assert f" answers (address {address}, [broker] in {file}:2)" in doctor.output()

    write(file, f'[broker]\nstart = true\naddress = "{address}"\n')
    doctor = lab_with_broker.run(*GECOS, "doctor")
    assert doctor.finish() == 1
    (said,) = (line for line in doctor.lines if line.startswith("error    broker: "))
    assert f"{file}:3: broker.address: this address names a broker that runs already" in said
    assert said.endswith(f"({file})")


def test_programs_of_gecos_up_use_the_broker_that_it_starts(
    lab_with_broker: Laboratory, file: Path, tmp_path: Path
) -> None:
    """Although the lab file of the machine names another one."""
    laboratory = tmp_path / "of-up.toml"
    program = 'run = ["sh", "-c", "echo serving $GECOS_BROKER; exec sleep 1000"]'
    for broker in ("", "[broker]\nstart = false\n"):
        write(laboratory, f"[programs.OVEN]\n{program}\n{broker}")
        up = lab_with_broker.start(*GECOS, "up", laboratory)
        up.wait_for("[OVEN] serving shm")
        assert up.terminate() == 0, str(up)
