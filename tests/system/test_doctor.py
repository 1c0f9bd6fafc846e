"""`gecos doctor` in laboratories that lack something, and `gecos keys` as it ends there."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from gecos import cli
from jsonschema import Draft202012Validator
from processes import Laboratory

DOCTOR = [sys.executable, "-m", "gecos.cli", "doctor"]
NETWORK_OF_ITS_OWN = ("unshare", "-n") if os.geteuid() == 0 else ("unshare", "-Urn")
SCHEMA = json.loads((Path(cli.__file__).parent / "output.schema.json").read_text())
WITHOUT_EXTENSION = """
import sys
sys.modules["gecos._core"] = None  # as if a library of it were missing
sys.argv = ["gecos", "doctor", "--json"]
from gecos.cli import main
sys.exit(main())
"""


def examined(lab: Laboratory, *before: str | Path) -> tuple[int, list[dict[str, Any]]]:
    """The exit code of the doctor, and its findings that are not ok."""
    return judged(lab, *before, *DOCTOR, "--json")


def judged(lab: Laboratory, *command: str | Path) -> tuple[int, list[dict[str, Any]]]:
    done = lab.run(*command)
    shown = json.loads(done.output())
    Draft202012Validator(SCHEMA | {"$ref": "#/$defs/doctor"}).validate(shown)
    code = done.finish()
    findings = shown["findings"]
    assert shown["healthy"] == (code == 0) == all(f["level"] != "error" for f in findings)
    assert all(bool(f["mend"]) == (f["level"] != "ok") for f in findings), str(done)
    return code, [finding for finding in findings if finding["level"] != "ok"]


def the(findings: list[dict[str, Any]], check: str, level: str) -> dict[str, Any]:
    (found,) = (f for f in findings if f["check"] == check and f["level"] == level)
    return found


def errors(findings: list[dict[str, Any]]) -> set[str]:
    return {finding["check"] for finding in findings if finding["level"] == "error"}


@pytest.fixture
def own_place(lab_with_broker: Laboratory, tmp_path: Path) -> Iterator[Laboratory]:
    """A runtime directory of its own, without a broker."""
    place = Path(f"/tmp/gd-{os.getpid()}")
    place.mkdir(mode=0o700)
    lab_with_broker.env["GECOS_RUNTIME_DIR"] = str(place)
    yield lab_with_broker
    subprocess.run(["rm", "-r", str(place)], check=True)


def place_of(lab: Laboratory) -> Path:
    return Path(lab.env["GECOS_RUNTIME_DIR"])


def test_without_a_route_lcm_is_not_usable_but_shm_is(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    code, findings = examined(lab, *NETWORK_OF_ITS_OWN)
    assert code == 0, findings
    found = the(findings, "multicast route", "warning")
    assert "239.255.76.67" in found["what"]
    commands = "ip link set lo multicast on && ip route add 239.255.76.67/32 dev lo"
    assert found["mend"] == f"sudo sh -c '{commands}'"

    lab.env["GECOS_LCM_TTL"] = "1"
    code, findings = examined(lab, *NETWORK_OF_ITS_OWN)
    assert code == 1
    assert errors(findings) == {"multicast route"}


def test_with_the_commands_that_it_gives_the_route_is_there(lab_with_broker: Laboratory) -> None:
    if os.geteuid() != 0:
        pytest.skip("needs root, to add a route")
    _, findings = examined(lab_with_broker, *NETWORK_OF_ITS_OWN)
    mend = the(findings, "multicast route", "warning")["mend"].removeprefix("sudo ")
    mended = f'ip link set lo up && {mend} && exec "$@"'
    code, findings = examined(lab_with_broker, *NETWORK_OF_ITS_OWN, "sh", "-c", mended, "sh")
    assert code == 0, findings
    assert not [f for f in findings if f["check"] == "multicast route"]


def test_a_broker_that_started_before_there_was_a_route(own_place: Laboratory) -> None:
    if os.geteuid() != 0:
        pytest.skip("needs root, to add a route")
    own_place.env["GECOS_LCM_TTL"] = "1"
    later = (
        'ip link set lo up; "$0" -m gecos.cli broker >"$GECOS_RUNTIME_DIR/said" 2>&1 & '
        'until "$0" -m gecos.cli ls >/dev/null 2>&1; do :; done; '
        "ip link set lo multicast on; ip route add 239.255.76.67/32 dev lo; "
        '"$@"; code=$?; kill $!; exit $code'
    )
    code, findings = examined(own_place, "unshare", "-n", "sh", "-uc", later, sys.executable)
    assert code == 0, findings
    found = the(findings, "broker over lcm", "warning")
    assert found["mend"] == "end the broker and the devices, and start them again"


def test_no_broker_and_a_left_over_socket(own_place: Laboratory) -> None:
    for name in ("BROKER.sock", f"RX90.{ended_process()}.1.sock"):
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as left:
            left.bind(str(place_of(own_place) / name))
    code, findings = examined(own_place, *NETWORK_OF_ITS_OWN)
    assert code == 1
    assert errors(findings) == {"broker"}
    assert str(place_of(own_place) / "BROKER.sock") in the(findings, "broker", "error")["what"]
    left_over = the(findings, "sockets", "warning")
    assert "RX90." in left_over["where"] and "BROKER.sock" in left_over["where"]

    subprocess.run(left_over["mend"], shell=True, check=True)
    _, findings = examined(own_place, *NETWORK_OF_ITS_OWN)
    assert not [f for f in findings if f["check"] == "sockets"]


def ended_process() -> int:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@contextmanager
def belonging_to(directory: Path, user: int) -> Iterator[None]:
    os.chown(directory, user, -1)
    yield
    os.chown(directory, os.geteuid(), -1)


def test_a_directory_of_another_user_and_one_that_all_may_write(own_place: Laboratory) -> None:
    place = place_of(own_place)
    place.chmod(0o777)
    code, findings = examined(own_place, *NETWORK_OF_ITS_OWN)
    assert code == 1
    assert the(findings, "runtime directory", "error")["mend"] == f"chmod go-w {place}"
    place.chmod(0o700)
    if os.geteuid() != 0:
        return
    with belonging_to(place, 65534):
        code, findings = examined(own_place, *NETWORK_OF_ITS_OWN)
    found = the(findings, "runtime directory", "error")
    assert (code, found["where"]) == (1, str(place))
    assert "belongs to uid 65534" in found["what"]
    assert "export GECOS_RUNTIME_DIR=" in found["mend"]


@pytest.mark.parametrize(
    ("variable", "value", "text"),
    [
        ("GECOS_LCM_TTL", "far", "GECOS_LCM_TTL is 'far'; it says how many routers"),
        ("GECOS_LOG", "loud", "GECOS_LOG"),
        ("GECOS_BROKER", "bluetooth:7", "'bluetooth:7' is not an address"),
    ],
)
def test_a_setting_that_is_not_valid_is_named(
    lab_with_broker: Laboratory, variable: str, value: str, text: str
) -> None:
    lab_with_broker.env[variable] = value
    code, findings = examined(lab_with_broker, *NETWORK_OF_ITS_OWN)
    assert code == 1
    (found,) = (finding for finding in findings if finding["level"] == "error")
    assert text in found["what"]
    assert variable in found["where"]


def test_without_the_extension_it_still_says_what_is_missing(lab: Laboratory) -> None:
    code, findings = judged(lab, sys.executable, "-c", WITHOUT_EXTENSION)
    assert code == 1
    assert errors(findings) == {"extension"}
    assert "gecos._core cannot be imported" in the(findings, "extension", "error")["what"]


def test_people_read_a_line_for_each_finding(own_place: Laboratory) -> None:
    done = own_place.run(*NETWORK_OF_ITS_OWN, *DOCTOR)
    assert done.finish() == 1
    begin = "error    broker: no broker answers"
    (broker,) = (line for line in done.lines if line.startswith(begin))
    assert done.lines[done.lines.index(broker) + 1] == (
        "         mend: gecos broker (or gecos up, which also starts devices)"
    )
    assert any(line.startswith("ok       extension: ") for line in done.lines)
