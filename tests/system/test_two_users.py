"""Two users of one host, one admitted and one not. Both users and root are needed, so users other
than root run these tests in a user namespace."""

import json
import os
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from processes import OTHER_USERS_MISSING, WITH_OTHER_USERS

TREE = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def _has_other_users() -> None:
    tried = subprocess.run([*WITH_OTHER_USERS, "true"], capture_output=True, text=True, check=False)
    assert tried.returncode == 0, f"{OTHER_USERS_MISSING}: {tried.stderr}"


def test_one_is_admitted_and_one_is_told_why_not(build: Path) -> None:
    program = build / "tests" / "cpp" / "session" / "two_users_test"
    ran = subprocess.run(
        [*WITH_OTHER_USERS, program], capture_output=True, text=True, timeout=120, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "NOT TRIED" not in ran.stdout
    assert "[  PASSED  ] 13 tests." in ran.stdout


def test_one_whom_a_program_admits_is_a_visitor_of_the_broker(build: Path) -> None:
    program = build / "tests" / "cpp" / "session" / "visitors_test"
    ran = subprocess.run(
        [*WITH_OTHER_USERS, program], capture_output=True, text=True, timeout=240, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "NOT TRIED" not in ran.stdout
    assert "[  PASSED  ] 15 tests." in ran.stdout


def test_gecos_ls_of_a_visitor_shows_what_programs_in_python_admit_the_user_to(
    build: Path,
) -> None:
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        lab_file = Path(folder) / "lab.toml"
        lab_file.touch(mode=0o644)
        subprocess.run([*WITH_OTHER_USERS, "chmod", "1777", folder], check=True)
        environment = {
            **os.environ,
            "GECOS_RUNTIME_DIR": folder,
            "GECOS_LAB_FILE": str(lab_file),
            "GECOS_AUDIT_DIR": f"{folder}/audit",
            "GECOS_KEY_DIR": f"{folder}/keys",
        }
        program = TREE / "tests" / "system" / "programs" / "visitor.py"
        broker = build / "runtime" / "cpp" / "gecos" / "broker" / "gecos-broker"
        ran = _run(environment, sys.executable, program, TREE / "tests" / "python", broker)
        written = _run(environment, "cat", f"{folder}/audit/audit.jsonl")
    listed, named, refused, allowed, other, denied, advice = ran.splitlines()
    assert listed == "root: LAMP OTHER"
    assert named == "daemon: LAMP: a lamp"
    assert refused.startswith("daemon: DENIED: 'stop' of BROKER was not started: user daemon of ")
    assert "BROKER refuses user bin of host" in other
    # The file says no to both, and the object yes to one.
    assert allowed.startswith(
        "daemon: 0: allowed: LAMP admits this program (asked now) / the lab file alone says "
        "denied: LAMP refuses user daemon of host"
    )
    assert "the server of LAMP runs as user root of host" in allowed
    # Python recognises the refusal by the text of the C++ library.
    assert denied.startswith("bin: 5: denied: the broker refuses this program: shm:")
    assert "BROKER refuses user bin of host" in denied
    assert "the user who runs the server of LAMP is not known, because the broker refuses" in denied
    lines = [line for line in map(json.loads, written.splitlines()) if line["user"] == "daemon"]
    events = [(line["object"], line["event"]) for line in lines]
    assert events.count(("LAMP", "connected")) == 3  # two of `look`, one of `gecos policy test`
    assert advice.startswith('bin: ask the user of the broker to write users = ["bin"] below')


def test_a_server_in_python_names_who_is_admitted() -> None:
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:  # whose path is short enough
        lab_file = Path(folder) / "lab.toml"
        lab_file.write_text('[objects.BROKER.allow]\nusers = ["*"]\n')
        lab_file.chmod(0o644)
        subprocess.run([*WITH_OTHER_USERS, "chmod", "1777", folder], check=True)
        places = {"GECOS_RUNTIME_DIR": folder, "GECOS_LAB_FILE": str(lab_file)}
        program = TREE / "tests" / "system" / "programs" / "two_users.py"
        ran = subprocess.run(
            [*WITH_OTHER_USERS, sys.executable, program, TREE / "tests" / "python"],
            env={**os.environ, **places},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    assert ran.returncode == 0, ran.stderr
    admitted, refused = ran.stdout.splitlines()
    assert admitted == "daemon: a lamp"
    assert refused.startswith("bin: LAMP: REFUSED: shm:")
    rule = (
        f"LAMP refuses user bin of host {socket.gethostname()}: the list in the program of "
        "the server (`allow`, or `users` and `hosts` of `serve`) does not name user "
        'bin; add "bin" to its users (request '
    )
    assert rule in refused


def test_a_broker_and_a_server_of_the_user_gecos_serve_all_users_of_the_host() -> None:
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        lab_file, users = Path(folder) / "lab.toml", Path(folder) / "passwd"
        lab_file.write_text('[objects.BROKER.allow]\nusers = ["*"]\n[allow]\nusers = ["daemon"]\n')
        users.write_text(Path("/etc/passwd").read_text() + "gecos:x:990:990::/:/usr/sbin/nologin\n")
        for file in (lab_file, users):
            file.chmod(0o644)
        subprocess.run([*WITH_OTHER_USERS, "chmod", "1777", folder], check=True)
        environment = {
            **os.environ,
            "GECOS_RUNTIME_DIR": folder,
            "GECOS_LAB_FILE": str(lab_file),
            "GECOS_AUDIT_DIR": f"{folder}/audit",
            "GECOS_KEY_DIR": f"{folder}/keys",
        }
        program = TREE / "tests" / "system" / "programs" / "user_gecos.py"
        # A mount of its own: the user is known to this program and its children alone.
        with_user_gecos = 'mount --bind "$1" /etc/passwd; shift; exec "$@"'
        alone = ("unshare", "-m", "sh", "-euc", with_user_gecos, "sh", users)
        ran = _run(environment, *alone, sys.executable, program, TREE / "tests" / "python")
    place, admitted, refused = ran.splitlines()
    assert place == "gecos serves in a folder of mode 711, at a socket of mode 666"
    assert admitted == "daemon: a lamp"
    assert refused.startswith("bin: LAMP: REFUSED: shm:")
    rule = f"[allow] in {lab_file}:3 does not name user bin"
    assert f"LAMP refuses user bin of host {socket.gethostname()}: {rule}" in refused


@pytest.fixture(params=["robcl-zone", "a zone of one's own"])
def zone_server(request: pytest.FixtureRequest, build: Path) -> list[str]:
    if request.param == "robcl-zone":
        return [str(build / "devices" / "zone" / "robcl-zone"), "--doors", "DOOR"]
    return [sys.executable, str(TREE / "tests" / "system" / "programs" / "own_zone.py")]


def test_the_lab_file_says_who_may_report_for_a_door(zone_server: list[str]) -> None:
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        lab_file = Path(folder) / "lab.toml"
        lab_file.write_text(
            '[objects.BROKER.allow]\nusers = ["*"]\n[objects.CELL.allow]\nusers = ["daemon"]\n'
        )
        lab_file.chmod(0o644)
        subprocess.run([*WITH_OTHER_USERS, "chmod", "1777", folder], check=True)
        environment = {
            **os.environ,
            "GECOS_RUNTIME_DIR": folder,
            "GECOS_LAB_FILE": str(lab_file),
            "GECOS_AUDIT_DIR": f"{folder}/audit",
        }
        program = TREE / "tests" / "system" / "programs" / "two_reporters.py"
        ran = _run(environment, sys.executable, program, *zone_server)
        own, stranger, bound, unbound = ran.splitlines()
        refusal, request = stranger.removesuffix(")").split(" (request ")
        explained = _run(environment, sys.executable, "-m", "gecos.cli", "why", request)
    host = socket.gethostname()
    assert own == "root: reported"
    why = (
        f"DENIED: a program of user daemon of host {host} may not report for DOOR of "
        "CELL: no [objects.CELL.sources] of a lab file binds this source, so only the user of the "
        f'zone\'s server may report for it; write DOOR = "daemon@{host}" under '
        "[objects.CELL.sources]"
    )
    assert refusal == f"daemon: {why}"
    assert f" CELL: daemon on {host} (" in explained, explained
    assert f"report_door ended {why}" in explained
    assert bound == "daemon: reported"
    assert "a program of user root" in unbound
    assert f"binds this source to user daemon of host {host}" in unbound


def _run(environment: dict[str, str], *command: str | Path) -> str:
    ran = subprocess.run(
        [*WITH_OTHER_USERS, *command],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout
