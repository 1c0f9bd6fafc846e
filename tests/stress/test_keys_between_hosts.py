"""Two network namespaces as two hosts, whose users have keys of their own: ben@desk joins by a
link, is refused, admitted by a list, moves RAIL, and is revoked. Programs with an unknown key get
nobody."""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hosts import Hosts
from processes import Laboratory, Program, until

GECOS = [sys.executable, "-m", "gecos.cli"]
REVOKED_WITHIN = 5.0  # s, as promised
CELL, DESK, CARL = 0, 1, 2

HOLDS = """
import gecos
from gecos.dynamic_client.connect import connect

rail = connect(gecos.Lab(), "RAIL")
with gecos.actor(rail) as lease:
    rail.travel(0.2).result()
    print("moves", flush=True)
    try:
        while True:
            rail.travel(1.0).result()
            rail.travel(0.0).result()
    except gecos.CommandFailed as error:
        print("ended:", error, flush=True)
    except ConnectionError as error:
        print("ended:", error, flush=True)
"""

MOVES_WITHOUT_STATUS = """
import gecos
from gecos.dynamic_client.connect import connect

try:
    connect(gecos.Lab(), "RAIL").travel(0.2).result()
except gecos.CommandFailed as error:
    print(error)
"""


@dataclass
class TwoHosts:
    """The broker and RAIL are on the host CELL. Programs of DESK have the key of another user."""

    hosts: Hosts
    labs: list[Laboratory]
    lab_file: Path

    def edit(self, text: str) -> None:
        """Writes the lab file. The edit acts at once: a young file would act .1 s later."""
        self.lab_file.write_text(text)
        os.utime(self.lab_file, (0, 0))

    def start(
        self,
        host: int,
        *command: str | Path,
        ready: str | None = None,
        listens: bool = False,
    ) -> Program:
        """Starts a program of a host, or of CARL, who works on CELL."""
        place = self.hosts.on(CELL if host == CARL else host)
        return self.labs[host].start(*place, *command, ready=ready, listens=listens)

    def broker(self, host: int) -> Program:
        command = self.labs[host].build / "runtime/cpp/gecos/broker/gecos-broker"
        return self.start(host, command, ready="ready")

    def rail(self, host: int) -> Program:
        return self.start(host, self.labs[host].build / "tests/system/rail/rail_server")

    def gecos(self, host: int, *words: str | Path) -> Program:
        program = self.start(host, *GECOS, *words)
        program.finish()
        return program

    def key_file(self, host: int) -> str:
        """Makes the key of a host's user at the first use."""
        return str(json.loads(self.gecos(host, "keys", "--json").output())["own"]["file"])

    def enrols(self, host: int, other: int, owner: str) -> None:
        """The user of `other` joins, and waits for the approval of the user of `host`."""
        address = f"10.77.0.{host + 1}"
        init = self.start(host, *GECOS, "lab", "init", "--address", address, "--as", "ann@cell")
        link = init.wait_for("gecos join ").split()[-1]
        joined = self.gecos(other, "join", link, "--as", owner, "--yes")
        assert joined.finish() == 0, str(joined)
        assert init.finish() == 0, str(init)
        assert joined.lines[-1] in init.output(), "both show the same fingerprint"

    def admits(self, host: int, other: int, *owner: str) -> None:
        added = self.gecos(host, "keys", "add", self.key_file(other), *owner)
        assert added.finish() == 0, added


@pytest.fixture
def two(build: Path, env: dict[str, str]) -> Iterator[TwoHosts]:
    with Hosts() as hosts, tempfile.TemporaryDirectory(prefix="gecos-") as place:
        lab_file = Path(place) / "lab.toml"
        lab_file.touch(mode=0o644)
        labs = []
        for host in range(2):
            folder = Path(place) / str(host)
            folder.mkdir(mode=0o700)
            labs.append(Laboratory(folder, build))
            labs[-1].env |= env | {
                "GECOS_LCM_TTL": "1",
                "GECOS_BROKER": "lcm",
                "GECOS_KEY_DIR": str(folder / "keys"),
                "GECOS_LAB_FILE": str(lab_file),
            }
        try:
            yield TwoHosts(hosts, labs, lab_file)
        finally:
            for lab in reversed(labs):
                lab.close()


def test_a_user_of_another_host_enrols_is_admitted_by_a_list_moves_and_is_revoked(
    two: TwoHosts,
) -> None:
    two.enrols(CELL, DESK, "ben@desk")
    two.broker(CELL)
    two.rail(CELL).wait_for("serving RAIL")

    stranger = two.gecos(DESK, "call", "RAIL", "measure")
    assert stranger.finish() == 4
    assert "no server answers, or the server does not admit our key" in stranger.output()
    assert "refuses" not in stranger.output(), "a stranger learns nothing"

    assert two.gecos(CELL, "approve", "ben@desk").finish() == 0
    refused = two.gecos(DESK, "call", "RAIL", "measure")
    assert refused.finish() == 4
    assert "BROKER refuses user ben of host desk: BROKER admits only" in refused.output()

    two.edit(
        '[objects.BROKER.allow]\nusers = ["ben"]\nhosts = ["desk"]\n[allow]\nusers = ["ben"]\n'
    )
    refused = two.gecos(DESK, "call", "RAIL", "measure")
    assert refused.finish() == 5
    rule = f'[allow] in {two.lab_file}:4 does not name host desk; add "desk" to its hosts'
    assert f"RAIL refuses user ben of host desk: {rule}" in refused.output()
    tested = two.gecos(CELL, "policy", "test", "ben", "desk", "RAIL")
    assert tested.finish() == 5 and rule in tested.output()

    two.edit('[allow]\nusers = ["ben"]\nhosts = ["desk"]\n')
    read = two.gecos(DESK, "call", "RAIL", "measure")
    assert read.finish() == 0, read
    holder = two.start(DESK, sys.executable, "-c", HOLDS, ready="moves")
    reader = two.start(DESK, *GECOS, "watch", "RAIL", "beam", ready="1.")
    held = two.gecos(CELL, "holders", "RAIL")
    assert "ben@desk" in held.output(), "as the key says, and not what the program says of itself"

    revoked = time.monotonic()
    told = two.gecos(CELL, "revoke", "ben@desk")
    assert told.finish() == 0, str(told)
    assert "of ben@desk" in told.output() and "reached   RAIL" in told.output()
    assert "was revoked: the key" in holder.wait_for("ended:")
    assert reader.finish() != 0
    assert time.monotonic() - revoked < 5 * REVOKED_WITHIN
    assert two.gecos(CELL, "call", "RAIL", "travel", '{"target": 0.5}').finish() == 0, (
        "the status is free"
    )

    stranger = two.gecos(DESK, "call", "RAIL", "measure")
    assert stranger.finish() == 4
    assert "no server answers, or the server does not admit our key" in stranger.output()


SERVES = """
import sys
import gecos

sys.path.insert(0, sys.argv[1])
from lamp import PlainLamp

with gecos.Lab() as lab, gecos.Server(lab) as server:
    server.allow(["ben"], ["desk"])
    server.add("LAMP", PlainLamp())
    print("serves LAMP", flush=True)
    sys.stdin.read()
"""


READS_LAMP = """
import sys
import gecos

sys.path.insert(0, sys.argv[1])
from lamp import Lamp

print(gecos.Lab().create(Lamp, "LAMP").label().result())
"""


def test_a_user_of_another_host_whom_the_program_admits_is_a_visitor_of_the_broker(
    two: TwoHosts,
) -> None:
    two.admits(DESK, CELL)
    two.admits(CELL, DESK, "ben@desk")
    two.broker(CELL)
    two.rail(CELL).wait_for("serving RAIL")
    refused = two.gecos(DESK, "ls")
    assert "BROKER refuses user ben of host desk" in refused.output()

    folder = Path(__file__).resolve().parents[1] / "python"
    two.start(CELL, sys.executable, "-c", SERVES, folder, ready="serves LAMP", listens=True)
    listed = json.loads(two.gecos(DESK, "ls", "--json").output())
    assert [found["name"] for found in listed] == ["LAMP"]
    watching = two.start(DESK, *GECOS, "ls", "--watch", ready="LAMP")
    read = two.start(DESK, sys.executable, "-c", READS_LAMP, folder)
    assert read.finish() == 0 and "a lamp" in read.output(), read
    hidden = two.gecos(DESK, "call", "RAIL", "measure").output()
    assert "no such object is online" in hidden and "the broker knows: LAMP" in hidden

    revoked = two.gecos(CELL, "revoke", "ben@desk")
    assert revoked.finish() == 0, str(revoked)
    until(
        lambda: two.gecos(DESK, "ls").finish() != 0,
        "the broker takes the visitor no more",
        5 * REVOKED_WITHIN,
    )
    watching.signal(signal.SIGINT)


READS = """
import sys
import gecos
from gecos.dynamic_client.connect import connect, connect_to

with gecos.Lab() as lab:
    (entry,) = [one for one in lab.objects() if one.name == "RAIL"]
    rail = connect(lab, "RAIL")
    stream = rail.beam.stream()
    rail.measure().result()
    print("reads", flush=True)
    for line in sys.stdin:
        if line == "end\\n":
            break
        try:
            with gecos.Lab() as other:
                connect_to(other, entry, patience=5.0)
            print("answer: admitted", flush=True)
        except gecos.CreateError as error:
            print("answer: refused:", error, flush=True)
        rail.measure().result()
        print("reads on", flush=True)
    try:
        while True:
            stream.next(30.0)
    except gecos.StreamLost as error:
        print(type(error).__name__, error, flush=True)
"""


@pytest.fixture
def carl(two: TwoHosts) -> Iterator[Laboratory]:
    """A third user, on the host CELL. The broker is on CELL; RAIL is on DESK, whose folder of keys
    is another one. Both admit carl@moor."""
    folder = two.lab_file.parent / "carl"
    folder.mkdir(mode=0o700)
    lab = Laboratory(folder, two.labs[CELL].build)
    lab.env |= two.labs[CELL].env | {"GECOS_KEY_DIR": str(folder / "keys")}
    two.labs.append(lab)
    two.edit('[allow]\nusers = ["carl"]\nhosts = ["moor"]\n')
    for host, other in ((CELL, DESK), (DESK, CELL), (CARL, CELL), (CARL, DESK)):
        two.admits(host, other)
    for host in (CELL, DESK):
        two.admits(host, CARL, "carl@moor")
    yield lab


def test_a_server_of_another_host_that_was_not_reached_is_listed(
    two: TwoHosts, carl: Laboratory
) -> None:
    two.broker(CELL)
    rail = two.rail(DESK)
    rail.wait_for("serving RAIL")
    rail.signal(signal.SIGSTOP)
    told = two.gecos(CELL, "revoke", "carl@moor")
    assert told.finish() == 3, str(told)
    assert "RAIL was not reached: its server runs as" in told.output()
    assert "the server applies the revocation when it reaches the broker again" in told.output()


def test_a_server_of_another_host_applies_a_revocation_that_it_hears_from_the_broker(
    two: TwoHosts, carl: Laboratory
) -> None:
    two.broker(CELL)
    two.rail(DESK).wait_for("serving RAIL")
    reader = two.start(CARL, sys.executable, "-c", READS, ready="reads", listens=True)
    revoked = time.monotonic()
    told = two.gecos(CELL, "revoke", "carl@moor")
    assert told.finish() == 0, str(told)
    assert "reached   RAIL: its sessions end within 5 s" in told.output()
    reader.tell("end")
    lost = reader.wait_for("StreamRevoked")
    assert time.monotonic() - revoked < 5 * REVOKED_WITHIN
    assert (
        "RAIL refuses user carl of host moor: the user who runs the broker has revoked this user"
        in lost
    )
    assert "carl@moor" in two.gecos(DESK, "keys").output(), "the folder of DESK is its user's own"

    two.admits(CELL, CARL, "carl@moor")
    until(
        lambda: two.gecos(CARL, "call", "RAIL", "measure").finish() == 0,
        "a user who is admitted again is not revoked any more",
    )


def test_a_server_that_the_broker_does_not_tell_the_revocations_admits_nobody_new(
    two: TwoHosts, carl: Laboratory
) -> None:
    two.broker(CELL)
    two.rail(DESK).wait_for("serving RAIL")
    reader = two.start(CARL, sys.executable, "-c", READS, ready="reads", listens=True)

    def answer() -> str:
        reader.tell("")
        said = reader.wait_for("answer:")
        reader.wait_for("reads on")  # the session of before goes on
        return said

    assert answer() == "answer: admitted"
    revoked = Path(two.labs[CELL].env["GECOS_KEY_DIR"]) / "revoked"
    revoked.write_text("damaged\n")
    refusal = "RAIL refuses user carl of host moor: the server has had no contact with the broker"
    until(lambda: refusal in answer(), "no new user of another host is admitted")
    revoked.unlink()
    until(lambda: answer() == "answer: admitted", "the server is in contact again")


def test_a_server_without_a_broker_applies_a_revocation_at_its_first_contact(
    two: TwoHosts, carl: Laboratory
) -> None:
    broker = two.broker(CELL)
    two.rail(DESK).wait_for("serving RAIL")
    reader = two.start(CARL, sys.executable, "-c", READS, ready="reads", listens=True)
    broker.kill()
    told = two.gecos(CELL, "revoke", "carl@moor")
    assert told.finish() == 3, str(told)
    reader.tell("end")
    two.broker(CELL)
    lost = reader.wait_for("StreamRevoked")
    assert "the user who runs the broker has revoked this user" in lost


def refused_at(two: TwoHosts, host: int) -> str:
    """RAIL does not start on this host. Returns what it says."""
    rail = two.rail(host)
    assert rail.finish() != 0, "it may not have this name"
    return rail.output()


def explained(two: TwoHosts, refusal: str) -> str:
    """What `gecos why` says on CELL about the request whose number is in `refusal`."""
    number = re.search(r"\(request ([0-9a-f-]+)\)", refusal)
    assert number, refusal
    told: list[str] = []

    def is_in_the_audit() -> bool:
        why = two.gecos(CELL, "why", number[1])
        told.append(why.output())
        return why.finish() == 0

    until(is_in_the_audit, f"the audit has a line about: {refusal}")
    return told[-1]


def test_why_explains_what_a_user_of_another_host_was_refused(two: TwoHosts) -> None:
    broker = '[objects.BROKER.allow]\nusers = ["*"]\nhosts = ["*"]\n'
    two.edit(broker + '[allow]\nusers = ["anna"]\nhosts = ["desk"]\n')
    two.admits(DESK, CELL)
    two.admits(CELL, DESK, "ben@desk")
    two.broker(CELL)
    two.rail(CELL).wait_for("serving RAIL")

    refused = two.gecos(DESK, "call", "RAIL", "measure")
    assert refused.finish() == 5, str(refused)
    rule = f'[allow] in {two.lab_file}:4 does not name user ben; add "ben" to its users'
    assert "REFUSED" in refused.output() and rule in refused.output()
    told = explained(two, refused.output())
    assert " RAIL: ben on desk: " in told and rule in told

    two.edit('[allow]\nusers = ["ben"]\nhosts = ["desk"]\n')
    denied = two.start(DESK, sys.executable, "-c", MOVES_WITHOUT_STATUS)
    assert denied.finish() == 0, str(denied)
    told = explained(two, denied.output())
    assert " RAIL: ben on desk (" in told
    assert "travel ended DENIED: 'travel' of RAIL needs actor status" in told


def test_a_name_that_the_lab_file_binds_goes_to_its_owner_alone(two: TwoHosts) -> None:
    everyone = '[objects.BROKER.allow]\nusers = ["*"]\nhosts = ["*"]\n[names]\n'
    two.edit(everyone + 'RAIL = "ann@cell"\n')
    two.labs[DESK].env["GECOS_LAB_FILE"] = str(two.lab_file.with_name("desk.toml"))
    two.lab_file.with_name("desk.toml").touch(mode=0o644)  # only the broker's file binds names
    two.admits(DESK, CELL)
    two.admits(CELL, DESK, "ben@desk")
    two.broker(CELL)

    told = refused_at(two, DESK)
    rule = f"[names] in {two.lab_file}:5 binds this name to user ann of host cell"
    assert f"a server of user ben of host desk may not register RAIL: {rule}" in told
    assert 'serve the object as this user, or write RAIL = "ben@desk" in that table' in told
    why = explained(two, told)
    assert "RAIL: ben on desk: may not register the object" in why and rule in why
    tested = two.gecos(CELL, "policy", "test", "ben", "desk", "RAIL", "--serve")
    assert tested.finish() == 5 and rule in tested.output()

    keyless = refused_at(two, CELL)  # the own key of the broker's user has no owner
    assert "a server whose key has no owner may not register RAIL" in keyless
    assert "gecos keys add FILE ann@cell" in keyless

    two.edit(everyone + 'RAIL = "ben"\n')
    broken = refused_at(two, DESK)
    assert "no server may register RAIL while the lab file has an error; correct it, or" in broken
    assert "or write an empty file, which removes all its lists: " in broken
    assert f"{two.lab_file}:5: names.RAIL: a user and a host are expected" in broken
    two.lab_file.chmod(0o666)
    assert "other users may write to the file" in refused_at(two, DESK), "nobody believes it"
    two.lab_file.chmod(0o644)

    two.edit(everyone + 'RAIL = "ben@desk"\n')
    two.rail(DESK).wait_for("serving RAIL")
    assert "a server whose key has no owner" in refused_at(two, CELL)
    listed = json.loads(two.gecos(CELL, "ls", "--json").output())
    assert [found["name"] for found in listed] == ["RAIL"]


def test_a_rogue_broker_and_a_rogue_server_of_the_same_name_get_nobody(two: TwoHosts) -> None:
    two.broker(DESK)
    two.rail(DESK).wait_for("serving RAIL")
    alone = two.gecos(CELL, "call", "RAIL", "measure")
    assert alone.finish() == 4
    assert (
        "this program does not admit the key of the server that answered: the key" in alone.output()
    )

    two.admits(DESK, CELL)  # the rogue may read the key of CELL, which is public
    two.broker(CELL)
    two.rail(CELL).wait_for("serving RAIL")
    listed = json.loads(two.gecos(CELL, "ls", "--json").output())
    (found,) = listed
    keyed = [address for address in found["addresses"] if address.startswith("lcm:")]
    own = Path(two.key_file(CELL)).stem
    assert keyed and all(address.endswith(f"#{own}") for address in keyed)
    assert two.gecos(CELL, "call", "RAIL", "measure").finish() == 0
