"""What the doctor says of given values."""

from __future__ import annotations

import errno
import os
import resource
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from gecos.cli.doctor import network, places, readings, real_time, resources, settings
from gecos.cli.doctor.broker import (
    Answer,
    BrokerPlace,
    broker,
    one_broker,
    over_lcm,
    unusable_lab_file,
)
from gecos.cli.doctor.extension import extension
from gecos.cli.doctor.finding import Finding, Level
from gecos.cli.doctor.keys import Kind, Place, own_key

NO_ROUTE = (
    "no broker answers; start `gecos up` (a laboratory on this machine) or `gecos broker`, or give "
    "the broker's address in GECOS_BROKER or below [broker] in the lab file (tried lcm: "
    "cannot send to 239.255.76.67: Network is unreachable (no multicast route? run as root:  "
    "ip link set lo multicast on && ip route add 239.255.76.67/32 dev lo))"
)

US = "ben@desk"
HERE = BrokerPlace()
BY_VARIABLE = BrokerPlace("lcm", "GECOS_BROKER")
BY_FILE = BrokerPlace("lcm", "[broker] in /etc/gecos/lab.toml:4")


def said(finding: Finding | None, level: Level, *parts: str) -> None:
    assert finding is not None
    assert finding.level is level, finding
    for part in parts:
        assert part in f"{finding.what} | {finding.where} | {finding.mend}", finding
    assert bool(finding.mend) == (level is not Level.OK)


def test_a_missing_library_is_named_with_its_package() -> None:
    missing = "libglib-2.0.so.0: cannot open shared object file: No such file or directory"
    found = extension(missing, [], "/opt/gecos")
    said(found, Level.ERROR, "libglib-2.0.so.0 is missing", "sudo apt-get install libglib2.0-0")
    missing = missing.replace("libglib-2.0.so.0", "libother.so.3")
    said(extension(missing, [], "/opt/gecos"), Level.ERROR, "install libother.so.3")


def test_an_extension_of_another_version_is_told_from_one_that_is_missing() -> None:
    other = extension(None, ["own_key"], "/opt/gecos/_core.so")
    said(other, Level.ERROR, "belongs to another version", "lacks own_key", "/opt/gecos/_core.so")
    none = extension("No module named 'gecos._core'", [], "/opt/gecos (there is no _core*.so)")
    said(none, Level.ERROR, "No module named 'gecos._core'", "there is no _core*.so")
    said(extension(None, [], "/opt/gecos/_core.so"), Level.OK)


def test_without_a_route_the_runtimes_own_commands_are_given() -> None:
    commands = (
        "sudo sh -c 'ip link set lo multicast on && ip route add 239.255.76.67/32 dev lo'",
        "cannot send to 239.255.76.67: Network is unreachable",
    )
    said(network.multicast_route(NO_ROUTE, needed=True), Level.ERROR, *commands)
    said(network.multicast_route(NO_ROUTE, needed=False), Level.WARNING, *commands)
    said(network.multicast_route(None, needed=True), Level.OK)
    silent = "no broker answers; start `gecos broker` (tried lcm:239.255.76.67:7668/GWBROKER: …)"
    said(network.multicast_route(silent, needed=True), Level.OK)


def test_ttl_0_matters_where_lcm_is_named() -> None:
    said(network.reach_of_packets(0, BY_VARIABLE), Level.WARNING, "GECOS_LCM_TTL=1", "each host")
    by_file = network.reach_of_packets(0, BY_FILE)
    said(by_file, Level.WARNING, "but [broker] in /etc/gecos/lab.toml:4 names lcm")
    said(network.reach_of_packets(0, HERE), Level.OK)
    said(network.reach_of_packets(1, BY_VARIABLE), Level.OK)


def test_small_buffers_are_told_in_bytes() -> None:
    small = network.socket_buffers(212992)
    said(small, Level.WARNING, "212992", "sudo sysctl -w net.core.rmem_max=2097152")
    said(small, Level.WARNING, "/proc/sys/net/core/rmem_max")
    said(network.socket_buffers(2097152), Level.OK)


def test_a_foreign_directory_is_replaced_and_an_open_one_closed() -> None:
    foreign = (
        "shm: /tmp/gecos-0 belongs to uid 65534, who could listen in; name a directory of your own "
        "in GECOS_RUNTIME_DIR"
    )
    where = "/tmp/gecos-0"
    said(
        places.runtime_directory(foreign, where),
        Level.ERROR,
        "belongs to uid 65534",
        'export GECOS_RUNTIME_DIR="$HOME/.gecos-run"',
    )
    open_to_all = (
        "shm: other users may write to /tmp/gecos-0 and could listen in; run:  "
        "chmod go-w /tmp/gecos-0"
    )
    found = places.runtime_directory(open_to_all, where)
    assert found.mend == "chmod go-w /tmp/gecos-0"
    assert found.what == "other users may write to /tmp/gecos-0 and could listen in"
    said(places.runtime_directory(None, where), Level.OK)


def test_left_over_sockets_are_a_warning_and_a_file_in_the_way_an_error() -> None:
    left = ["/tmp/gecos-0/RX90.4711.1.sock", "/tmp/gecos-0/BROKER.sock"]
    said(places.stale_sockets(left), Level.WARNING, *left, f"rm {' '.join(left)}")
    said(places.stale_sockets([]), Level.OK)
    said(places.occupied(["/tmp/gecos-0/BROKER.sock"]), Level.ERROR, "not a socket", "rm -r /tmp")
    assert places.occupied([]) is None


def test_a_path_is_quoted_for_the_shell() -> None:
    odd = "/tmp/Ann's files; reboot"
    left, other = f"{odd}/A.sock", f"{odd}/B.sock"
    assert shlex.split(places.stale_sockets([left, other]).mend) == ["rm", left, other]
    in_the_way = places.occupied([left])
    assert in_the_way is not None
    assert shlex.split(in_the_way.mend) == ["rm", "-r", left]
    problem = f"shm: other users may write to {odd} and could listen in; run:  chmod go-w {odd}"
    assert shlex.split(places.runtime_directory(problem, odd).mend) == ["chmod", "go-w", odd]
    folder = Place(odd, Kind.FOLDER, shared=True)
    mend = own_key("…", folder, Place(f"{odd}/own.secret", Kind.MISSING)).mend
    assert shlex.split(mend) == ["chmod", "700", odd]


def key_finding(folder: Path) -> Finding:
    """The finding of the doctor about the folder of keys that GECOS_KEY_DIR names."""
    return own_key(
        readings.key_problem(),
        readings.place(folder, follow_symlinks=True),
        readings.place(folder / "own.secret", follow_symlinks=False),
    )


def open_folder(folder: Path) -> None:
    folder.chmod(0o755)


def open_key(folder: Path) -> None:
    (folder / "own.secret").chmod(0o644)


def damaged_key(folder: Path) -> None:
    (folder / "own.secret").write_text("gecos-secret-1 9f3c21aa")


def folder_for_a_key(folder: Path) -> None:
    (folder / "own.secret").unlink()
    (folder / "own.secret").mkdir()


def file_for_a_folder(folder: Path) -> None:
    folder.rename(folder.with_name("elsewhere"))
    folder.touch(0o600)


def key_of_another(folder: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("needs root, to give a file to another user")
    os.chown(folder / "own.secret", 65534, -1)


@pytest.mark.parametrize(
    ("spoil", "begin"),
    [
        (open_folder, "chmod 700 "),
        (open_key, "chmod 600 "),
        (damaged_key, "rm -r "),
        (folder_for_a_key, "rm -r "),
        (file_for_a_folder, "mkdir -m 700 "),
        (key_of_another, "mkdir -m 700 "),
    ],
)
def test_a_key_that_cannot_be_used_is_mended_by_what_is_told(
    spoil: Callable[[Path], None], begin: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "Ann's keys"
    monkeypatch.setenv("GECOS_KEY_DIR", str(folder))
    monkeypatch.setenv("HOME", str(tmp_path))
    assert readings.key_problem() is None
    said(key_finding(folder), Level.OK)
    spoil(folder)
    found = key_finding(folder)
    said(found, Level.ERROR, str(folder))
    assert found.mend.startswith(begin)

    mended = f'{found.mend.removesuffix(" && gecos keys")} && echo "$GECOS_KEY_DIR"'
    done = subprocess.run(mended, shell=True, stdout=subprocess.PIPE, text=True, check=True)
    folder = Path(done.stdout.removesuffix("\n"))
    monkeypatch.setenv("GECOS_KEY_DIR", str(folder))
    said(key_finding(folder), Level.OK)


def test_a_lab_without_descriptors_is_no_wrong_setting(place: Path) -> None:
    assert readings.lab_problem() is None
    readings.ask_broker("shm")  # imports what it needs
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with (place / "last").open("w") as last:
        resource.setrlimit(resource.RLIMIT_NOFILE, (last.fileno() + 1, hard))
        try:
            problem = readings.lab_problem()
            answer = readings.ask_broker("shm")
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert isinstance(problem, OSError)
    assert problem.errno == errno.EMFILE
    assert "Too many open files" in (answer.reason or "")
    reason = problem.strerror or ""
    found = resources.exhausted(errno.EMFILE, reason, may_rise=True)
    said(found, Level.ERROR, "Too many open files", 'ulimit -n "$(ulimit -Hn)"')
    for_ever = resources.exhausted(errno.EMFILE, reason, may_rise=False)
    said(for_ever, Level.ERROR, "nofile 65536", "limits.d/gecos.conf")
    said(resources.exhausted(errno.ENOMEM, "…", may_rise=False), Level.ERROR, "end programs")


def test_a_refusal_that_names_no_variable_does_not_unset_the_environment() -> None:
    assert settings.refused("", "why").mend == "unset the variables that begin with GECOS_"


def test_without_sealed_memory_shm_is_not_usable() -> None:
    said(places.shared_memory("Operation not permitted"), Level.ERROR, "not permitted", "memfd")
    said(places.shared_memory(None), Level.OK)


@pytest.mark.parametrize(
    ("limit", "capabilities", "level"),
    [(0, 0, Level.WARNING), (80, 0, Level.OK), (-1, 0, Level.OK), (0, 1 << 23, Level.OK)],
)
def test_real_time_priority(limit: int, capabilities: int, level: Level) -> None:
    said(real_time.priority(limit, capabilities), level)


@pytest.mark.parametrize(
    ("limit", "capabilities", "level"),
    [(65536, 0, Level.WARNING), (1 << 30, 0, Level.OK), (-1, 0, Level.OK), (0, 1 << 14, Level.OK)],
)
def test_locked_memory(limit: int, capabilities: int, level: Level) -> None:
    said(real_time.locked_memory(limit, capabilities), level)


def test_a_misspelt_setting_is_told_the_right_one() -> None:
    (found,) = settings.unknown({"GECOS_BROKR": "shm", "GECOS_LOG": "info", "HOME": "/"})
    said(found, Level.WARNING, "GECOS_BROKR", "did you mean GECOS_BROKER?", "unset GECOS_BROKR")
    assert settings.unknown({"GECOS_BUILD": "build"}) == []


def test_no_broker_says_where_it_was_looked_for() -> None:
    reason = "no broker answers; start `gecos broker` (tried shm:/tmp/gecos-0/BROKER.sock: nobody)"
    found = broker(Answer(reason), HERE, US)
    said(found, Level.ERROR, "shm:/tmp/gecos-0/BROKER.sock: nobody", "this host", "gecos broker")
    named = broker(Answer(reason), BY_VARIABLE, US)
    said(named, Level.ERROR, "GECOS_BROKER=lcm")
    named = broker(Answer(reason), BY_FILE, US)
    said(named, Level.ERROR, "address lcm, [broker] in /etc/gecos/lab.toml:4")


def test_a_key_that_is_not_admitted_is_no_missing_broker() -> None:
    refused = "(tried lcm: we refused the server: its key 92e3bf70 is not admitted here)"
    mend = broker(Answer(refused), BY_VARIABLE, US).mend
    assert mend.startswith("gecos keys add FILE USER@HOST, with"), "no key without an owner"
    perhaps = "(tried lcm: no server answers, or the server does not admit our key c1075034)"
    mend = broker(Answer(perhaps), BY_VARIABLE, US).mend
    assert mend.startswith("run gecos broker on the host")
    assert "ask its user to run gecos keys add FILE ben@desk, where" in mend


@pytest.mark.parametrize(
    ("because", "mend"),
    [
        (
            '[allow] in /etc/gecos/lab.toml:1 does not name user ben; add "ben" to its users',
            'ask the user of the broker to add "ben" to the users of [allow] in '
            "/etc/gecos/lab.toml",
        ),
        (
            '[objects.BROKER.allow] in a.toml:3 does not name host desk; add "desk" to its hosts',
            'ask the user of the broker to add "desk" to the hosts of [objects.BROKER.allow] in '
            "a.toml",
        ),
        (
            "the list in the program of the server (`allow`, or `users` and `hosts` of `serve`) "
            'does not name user ben; add "ben" to its users',
            'ask the user of the broker to add "ben" to the users of the list in the program of '
            "the broker",
        ),
        (
            "BROKER admits only user root of host cell; "
            'write users = ["ben"] below [allow] in a.toml',
            'ask the user of the broker to write users = ["ben"] below [allow] in a.toml',
        ),
        (
            "the user who runs the broker has revoked this user",
            "ask the user of the broker to admit this user",
        ),
    ],
)
def test_a_user_whom_the_broker_refuses_is_not_told_to_start_another_one(
    because: str, mend: str
) -> None:
    refusal = f"shm:/run/BROKER.sock: BROKER refuses user ben of host cell: {because}"
    answer = Answer(f"the broker refuses this program: {refusal} (request 1a-2b-3)")
    found = broker(answer, HERE, US)
    said(found, Level.ERROR, f"the broker refuses this user: {refusal}", "this host")
    assert found.mend == mend


def test_a_broker_of_another_version_and_a_second_one_are_warnings() -> None:
    old = Answer(None, 7, "process 4711", ours=False)
    said(broker(old, HERE, US), Level.WARNING, "process 4711", "another version")
    ours = Answer(None, 8, "process 4712")
    said(broker(ours, HERE, US), Level.OK, "process 4712 answers", "this host")
    said(broker(ours, BY_FILE, US), Level.OK, "address lcm, [broker] in /etc/gecos/lab.toml:4")
    said(one_broker([old, ours]), Level.WARNING, "process 4711", "process 4712")
    assert one_broker([ours, ours]) is None
    assert one_broker([ours, Answer("no broker answers")]) is None


def test_a_broker_that_is_not_served_over_lcm() -> None:
    ours, nobody = Answer(None, 7, "process 4711"), Answer("no server answers")
    said(over_lcm(ours, nobody), Level.WARNING, "process 4711", "start them again")
    assert over_lcm(ours, ours) is None
    assert over_lcm(nobody, nobody) is None


def test_a_place_of_the_broker_that_is_no_address() -> None:
    reason = Answer("'cell' is not an address")
    found = broker(reason, BrokerPlace("cell", "GECOS_BROKER"), US)
    said(found, Level.ERROR, "'cell' is not an address", "export GECOS_BROKER=lcm")
    found = broker(reason, BrokerPlace("cell", "[broker] in lab.toml:4"), US)
    said(found, Level.ERROR, 'write address = "lcm" at [broker] in lab.toml:4')


def test_a_lab_file_that_may_name_the_broker_and_cannot_be_used() -> None:
    problem = "the lab file, which may name the broker, cannot be used: lab.toml:2: …; correct that"
    said(unusable_lab_file(problem, "lab.toml"), Level.ERROR, "lab.toml:2: …", "correct that")
