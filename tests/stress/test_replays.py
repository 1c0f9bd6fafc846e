"""Two network namespaces as two hosts, and between them an attacker who hears, keeps and repeats
each frame. Frames that are played back execute nothing, and contain no password."""

from __future__ import annotations

import base64
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hosts import Hosts
from processes import Laboratory, Program, until

PROGRAMS = Path(__file__).with_name("programs")
GECOS = [sys.executable, "-m", "gecos.cli"]
CELL, DESK = 0, 1
PASSWORDS = ("Rosenkavalier", "Xylophonspieler")  # of the status, and a wrong one

SHARES = """
import gecos, sys
from robcl.frames import mm, translate
from robcl.manipulator import Manipulator, Trajectory

right, wrong = sys.stdin.readline().split()
labs = [gecos.Lab() for _ in range(3)]
one, other, stranger = (lab.create(Manipulator, "RX90", medium="lcm") for lab in labs)
start = one.tool().result()
with gecos.actor(one, right):
    one.move(start * translate(0.0, 0.0, -mm(50)), Trajectory(speed=0.2)).result()
    with gecos.actor(other, right):
        gecos.take_over(other).result()
        other.move(start, Trajectory(speed=0.2)).result()
        gecos.give_back(other).result()
    try:
        gecos.actor(stranger, wrong)
    except gecos.LeaseRefused as refused:
        print("refused:", refused, flush=True)
    stranger.move(start).exception()
print("moved", flush=True)
"""


@dataclass
class Line:
    """DANCER and the arm are on the host CELL, all other programs on DESK."""

    build: Path
    hosts: Hosts
    labs: list[Laboratory]
    relay: Program
    capture: Path

    def start(self, host: int, *command: str | Path, ready: str | None = None) -> Program:
        return self.labs[host].start(*self.hosts.on(host), *command, ready=ready)

    def dancer(self, program: str = "stress_dancer") -> Program:
        return self.start(CELL, self.build / "tests/stress" / program, ready="serving DANCER")

    def client(self, password: str) -> Program:
        command = (sys.executable, PROGRAMS / "dance.py", password)
        client = self.labs[DESK].start(*self.hosts.on(DESK), *command, listens=True)
        client.wait_for("holds")
        return client

    def keep(self) -> bytes:
        """Writes all that was heard so far to `capture`."""
        self.relay.tell(f"keep {self.capture}")
        self.relay.wait_for("kept")
        return self.capture.read_bytes()

    def play(self, order: str) -> int:
        self.relay.tell(f"play {order}")
        return int(self.relay.wait_for("played").split()[1])

    def read_by(self, host: int) -> int:
        """How many datagrams the programs of a host have read."""
        shown = self.start(host, "cat", "/proc/net/snmp")
        shown.finish()
        names, values = (line.split() for line in shown.lines if line.startswith("Udp:"))
        return int(values[names.index("InDatagrams")])


@pytest.fixture
def line(build: Path, env: dict[str, str]) -> Iterator[Line]:
    with Hosts() as hosts, tempfile.TemporaryDirectory(prefix="gecos-") as place:
        labs = []
        for host in range(2):
            folder = Path(place) / str(host)
            folder.mkdir(mode=0o700)
            labs.append(Laboratory(folder, build))
            labs[-1].env |= env | {
                "GECOS_LCM_TTL": "1",
                "GECOS_BROKER": "lcm",
                "GECOS_LOG": "debug",
                "GECOS_AUDIT_DIR": str(folder / "audit"),
            }
        try:
            between = (*hosts.between(), sys.executable, PROGRAMS / "relay.py")
            relay = labs[DESK].start(*between, listens=True)
            relay.wait_for("relays")
            line = Line(build, hosts, labs, relay, Path(place) / "capture.pcap")
            line.start(DESK, build / "runtime/cpp/gecos/broker/gecos-broker", ready="ready")
            yield line
        finally:
            for lab in reversed(labs):
                lab.close()


def did(server: Program) -> Counter[str]:
    return Counter(line for line in server.lines if line.startswith("did "))


def asks(client: Program, words: str, answer: str) -> None:
    client.tell(words)
    client.wait_for(answer)


def probe(server: Program, client: Program, number: int) -> Counter[str]:
    """Lets the client do something new. What it does, once that has happened: then the server has
    read all that came before."""
    asks(client, "feet", "feet 2")
    asks(client, f"speed {number / 1000:g}", "sent")
    does = Counter(("did feet", f"did speed {number / 1000:g}"))
    until(lambda: f"did speed {number / 1000:g}" in did(server), "the sample came")
    return does


ORDERS = ("same", "shuffled", "doubled")


def session(server: Program, client: Program) -> Counter[str]:
    """A session that moves something. Returns what the server did in it."""
    asks(client, "move", "moved 0.100")
    asks(client, "speed 0.5", "sent")
    asks(client, "remark hello", "sent")
    alters = (f"did alter {count}" for count in (1, 2, 3, 4, -1))
    expected = Counter(["did follow", *alters, "did speed 0.5", "did remark hello"])
    until(lambda: did(server).keys() == expected.keys(), "the session is executed")
    return expected


def plays_after(line: Line, server: Program, expected: Counter[str], first: int) -> None:
    """Plays back all that was heard. Each time a new client is served, and gets the status: a
    grant that was played back would have another password."""
    for number, order in enumerate(ORDERS, first):
        line.play(order)
        client = line.client(order)
        expected += probe(server, client, number)
        assert did(server) == expected, order
        client.end_of_input()
        assert client.finish() == 0, str(client)


def test_a_session_that_is_played_back_executes_nothing(line: Line) -> None:
    server = line.dancer()
    client = line.client("Rosenkavalier")
    expected = session(server, client) + probe(server, client, 100)
    assert did(server) == expected, "all frames came twice, and each call and sample acted once"

    for number, order in enumerate(ORDERS, 101):  # while the session lives and has the status
        before = line.read_by(CELL)
        played = line.play(order)
        expected += probe(server, client, number)
        assert did(server) == expected, order
        # Some were for ports that are closed by now.
        assert line.read_by(CELL) - before > played / 2 > 10, "the server has read them"

    asks(client, "stop", "stopped")
    until(lambda: "did stop" in did(server), "the servant was told of the stop")
    expected += Counter(["did stop"])
    client.end_of_input()
    assert client.finish() == 0, str(client)
    plays_after(line, server, expected, 200)

    assert server.terminate() == 0
    server = line.dancer()
    plays_after(line, server, Counter(), 300)
    listed = line.start(DESK, *GECOS, "ls", "--json")
    assert listed.finish() == 0, str(listed)
    (text,) = (one for one in listed.lines if one.startswith("["))
    (found,) = (one for one in json.loads(text) if one["name"] == "DANCER")
    assert found["pid"] == server.pid, "the broker keeps the name for the server of today"


def test_a_server_without_windows_is_found_to_execute_what_comes_twice(line: Line) -> None:
    server = line.dancer("stress_dancer_without_windows")
    client = line.client("Rosenkavalier")
    asks(client, "feet", "feet 2")
    line.play("same")
    until(lambda: did(server)["did feet"] > 1, "a call that was played back is executed")


def forms(password: str) -> Iterator[bytes]:
    """The password as programs write texts: also within a longer one, in base64 and hexadecimal."""
    for text in (password.encode(), password.encode("utf-16-le"), password.encode("utf-16-be")):
        yield text
        yield text.hex().encode()
        yield text.hex().upper().encode()
        for before in range(3):
            coded = base64.b64encode(bytes(before) + text).rstrip(b"=")
            yield coded[(0, 2, 3)[before] : -1]  # without what depends on its neighbours


def occurs(password: str, found: bytes) -> bool:
    return any(form in found for form in forms(password))


@pytest.mark.parametrize(
    "written",
    [
        b"..Rosenkavalier..",
        b"\0" + "Rosenkavalier".encode("utf-16-le"),
        base64.b64encode(b'{"password": "Rosenkavalier"}'),
        base64.b64encode(b'{"password": "Rosenkavalier" }')[3:],
        base64.b64encode(b' {"password": "Rosenkavalier"}'),
        b"526f73656e6b6176616c696572",
    ],
)
def test_the_search_finds_a_password(written: bytes) -> None:
    assert occurs("Rosenkavalier", written)
    assert not occurs("Xylophonspieler", written)


def test_neither_capture_nor_log_nor_audit_nor_recording_contains_a_password(
    line: Line, build: Path, tmp_path: Path
) -> None:
    line.start(CELL, build / "devices/rx90/robcl-rx90", ready="ready")
    table = tmp_path / "motion.csv"
    words = ("plot", "RX90", "--seconds", "1", "--csv", table)
    plot = line.start(DESK, *GECOS, *words, ready="waits until")
    watch = line.start(DESK, *GECOS, "holders", "RX90", "--watch", "--json", ready="[")
    sharing = line.labs[DESK].start(
        *line.hosts.on(DESK), sys.executable, "-c", SHARES, listens=True
    )
    sharing.tell(" ".join(PASSWORDS))  # the arguments of a program are public
    sharing.wait_for("refused:")
    sharing.wait_for("moved")
    assert sharing.finish() == 0, str(sharing)
    assert plot.finish() == 0, str(plot)
    capture = line.keep()
    for lab in reversed(line.labs):
        lab.close()

    (audit,) = (line.labs[CELL].env["GECOS_AUDIT_DIR"],)
    lines = b"".join(file.read_bytes() for file in Path(audit).iterdir())
    logs = "\n".join(str(program) for lab in line.labs for program in lab.programs).encode()
    searched = {"capture": capture, "log": logs, "audit": lines, "table": table.read_bytes()}
    for password in PASSWORDS:
        for where, found in searched.items():
            assert not occurs(password, found), f"{password} is in the {where}"
    for event in (b"status_granted", b"taken_over", b"given_back", b"status_refused"):
        assert event in lines, "the audit is about these requests"
    assert b"password" in lines and b"debug" in logs and len(capture) > 10_000
    assert len(table.read_text().splitlines()) > 10 and any("taken" in one for one in watch.lines)
