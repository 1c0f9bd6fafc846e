"""`gecos lab init`, `join` and `approve`: two users who exchange keys by a link."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from command_output import valid
from gecos.enrolment import JoinUrl
from gecos.key_folder import this_user

GECOS = [sys.executable, "-m", "gecos.cli"]
PATIENCE_S = 60.0


class User:
    """A user with a key folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.env = {**os.environ, "GECOS_KEY_DIR": str(folder)}

    def gecos(self, *words: str, answer: str = "y") -> tuple[int, str]:
        done = subprocess.run(
            [*GECOS, *words],
            env=self.env,
            input=f"{answer}\n",
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )
        return done.returncode, done.stdout + done.stderr

    def owners(self) -> list[str]:
        code, out = self.gecos("keys", "--json")
        assert code == 0, out
        return [one["owner"] for one in json.loads(out)["admitted"]]


class Laboratory(User):
    """A user who invites. The program waits until somebody has joined."""

    def invite(self, *words: str) -> str:
        self.waiting = subprocess.Popen(
            [*GECOS, "lab", "init", "--address", "localhost", "--as", "ann@cell", "--json", *words],
            env=self.env,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.waiting.stdout is not None
        line = self.waiting.stdout.readline()
        assert valid(line, "lab init")
        return str(json.loads(line)["link"])

    def heard(self) -> tuple[int, str, str]:
        out, err = self.waiting.communicate(timeout=PATIENCE_S)
        return self.waiting.returncode, out, err


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[Laboratory]:
    cell = Laboratory(tmp_path / "cell")
    yield cell
    cell.waiting.kill()
    cell.waiting.communicate()


@pytest.fixture
def desk(tmp_path: Path) -> User:
    return User(tmp_path / "desk")


def test_two_users_admit_each_other_by_a_link_and_an_approval(cell: Laboratory, desk: User) -> None:
    code, out = desk.gecos("join", cell.invite(), "--as", "ben@desk", "--yes")
    assert code == 0, out
    fingerprint = out.splitlines()[-1]
    code, said, _ = cell.heard()
    assert code == 0
    assert valid(said, "lab init")
    assert json.loads(said)["owner"] == "ben@desk"
    assert cell.owners() == [], "nobody is admitted before the approval"

    code, out = cell.gecos("approve", "ben@desk")
    assert code == 0, out
    assert f"admitted  {fingerprint}  ben@desk" in out
    assert cell.owners() == ["ben@desk"]
    assert desk.owners() == ["ann@cell"]
    code, out = cell.gecos("approve", "ben@desk")
    assert code == 2
    assert "ben@desk: nobody of this name asked to join; waiting: nobody" in out


def test_nobody_is_admitted_whom_the_user_does_not_expect(cell: Laboratory, desk: User) -> None:
    code, out = desk.gecos("join", cell.invite(), "--as", "ben@desk", answer="n")
    assert code == 2
    assert "Admit the laboratory of ann@cell, with the key" in out
    assert desk.owners() == []


@pytest.mark.parametrize("claimed", ["root", this_user()])
def test_a_laboratory_is_not_admitted_as_this_user(
    cell: Laboratory, desk: User, claimed: str
) -> None:
    link = cell.invite("--as", f"{claimed}@{socket.gethostname()}")
    code, out = desk.gecos("join", link, "--as", "ben@desk")
    assert code == 2
    assert "is admitted to all your objects, so no list would limit this key" in out
    assert desk.owners() == []


def test_another_key_of_a_known_user_needs_a_revocation(
    cell: Laboratory, desk: User, tmp_path: Path
) -> None:
    assert desk.gecos("join", cell.invite(), "--as", "ben@desk")[0] == 0
    assert cell.heard()[0] == 0
    false = Laboratory(tmp_path / "false")
    code, out = desk.gecos("join", false.invite(), "--as", "ben@desk")
    assert code == 2
    assert "ann@cell has another key here" in out
    assert "run `gecos revoke ann@cell` first" in out
    assert false.heard()[0] == 0


def test_a_damaged_request_is_named(desk: User) -> None:
    assert desk.gecos("keys")[0] == 0
    damaged = desk.folder / "joining" / f"{'a' * 64}.owner"
    damaged.parent.mkdir()
    damaged.write_bytes(b"\xff\n")
    code, out = desk.gecos("approve", "ben@desk")
    assert code == 2
    assert f"{damaged}: this file is not a valid request to join; remove it" in out


def test_an_invitation_works_once(cell: Laboratory, desk: User, tmp_path: Path) -> None:
    link = cell.invite()
    assert desk.gecos("join", link, "--as", "ben@desk")[0] == 0
    assert cell.heard()[0] == 0
    late = User(tmp_path / "late")
    code, out = late.gecos("join", link, "--as", "eve@bench")
    assert code == 2
    assert "the link was used, or has expired" in out
    assert "`gecos lab init` prints it" in out
    assert late.owners() == []


def test_who_reads_the_link_first_joins_and_is_known_by_the_fingerprint_alone(
    cell: Laboratory, desk: User, tmp_path: Path
) -> None:
    link = cell.invite()
    stranger = User(tmp_path / "stranger")
    code, out = stranger.gecos("join", link, "--as", "ben@desk", "--yes")
    assert code == 0, out
    of_stranger = out.splitlines()[-1]
    code, out = desk.gecos("join", link, "--as", "ben@desk")
    assert code == 2 and "the link was used" in out, "ben learns that somebody was faster"
    assert json.loads(cell.heard()[1])["owner"] == "ben@desk"
    assert of_stranger not in desk.gecos("keys")[1]
    assert f"admitted  {of_stranger}  ben@desk" in cell.gecos("approve", "ben@desk")[1]


def other_secret(url: JoinUrl) -> JoinUrl:
    return JoinUrl(url.host, url.port, url.key, bytes(16))


def other_laboratory(url: JoinUrl) -> JoinUrl:
    return JoinUrl(url.host, url.port, "0" * 64, url.secret)


@pytest.mark.parametrize("change", [other_secret, other_laboratory])
def test_who_has_not_the_right_link_is_refused_and_the_invitation_stays(
    cell: Laboratory, desk: User, tmp_path: Path, change: Callable[[JoinUrl], JoinUrl]
) -> None:
    link = cell.invite()
    stranger = User(tmp_path / "stranger")
    code, out = stranger.gecos("join", str(change(JoinUrl.parse(link))), "--as", "eve@bench")
    assert code == 2
    assert "this link does not belong to an invitation of this laboratory" in out
    assert stranger.owners() == []
    assert desk.gecos("join", link, "--as", "ben@desk")[0] == 0
    assert json.loads(cell.heard()[1])["owner"] == "ben@desk"


GARBAGE = (
    b"",
    b"\xff\n",
    b"[1]\n",
    b'{"key": 7}\n',
    b'{"key": "%s", "owner": "\\ud800", "proof": "\\udfff"}\n' % (b"0" * 64),
    b"[" * 4096,
    b"x" * 5000,
)


def test_garbage_and_a_silent_stranger_do_not_end_the_wait(cell: Laboratory, desk: User) -> None:
    link = cell.invite()
    where = JoinUrl.parse(link)
    for garbage in GARBAGE:
        with socket.create_connection((where.host, where.port), PATIENCE_S) as line:
            line.sendall(garbage)
    with socket.create_connection((where.host, where.port), PATIENCE_S):
        code, out = desk.gecos("join", link, "--as", "ben@desk")
    assert code == 0, out
    code, said, errors = cell.heard()
    assert (code, errors) == (0, "")
    assert json.loads(said)["owner"] == "ben@desk"


def test_nobody_joins_under_a_name_that_no_list_limits(cell: Laboratory, desk: User) -> None:
    link = cell.invite()
    host = socket.gethostname()
    for owner in (f"root@{host}", f"{this_user()}@{host}"):
        code, out = desk.gecos("join", link, "--as", owner)
        assert code == 2
        assert f"{owner} is admitted to everything here" in out
    assert desk.owners() == []


def test_a_text_of_a_false_laboratory_reaches_no_terminal(desk: User) -> None:
    with socket.create_server(("localhost", 0)) as false:
        link = JoinUrl("localhost", false.getsockname()[1], "0" * 64, bytes(16))
        joining = subprocess.Popen(
            [*GECOS, "join", str(link), "--as", "ben@desk"],
            env=desk.env,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        with false.accept()[0] as line:
            line.sendall(b'{"refused": "\\u001b[2Jrun: rm -r keys"}\n')
            out, _ = joining.communicate(timeout=PATIENCE_S)
    assert joining.returncode == 2
    assert "rm -r keys" not in out
    assert "the answer is not from the laboratory of the link" in out


def test_an_invitation_expires(cell: Laboratory) -> None:
    cell.invite("--minutes", "0.001")
    code, out, _ = cell.heard()
    assert code == 3
    assert "nobody joined while the invitation was valid" in out


def test_what_is_no_link_or_no_owner_is_refused(cell: Laboratory, desk: User) -> None:
    link = cell.invite()
    no_port = re.sub(r":\d+/", ":99999/", link)
    for wrong in (link[:-1], no_port):
        code, out = desk.gecos("join", wrong)
        assert code == 2
        assert "this is not a whole link" in out
    no_host = str(replace(JoinUrl.parse(link), host="x" * 64))
    code, out = desk.gecos("join", no_host, "--as", "ben@desk")
    assert code == 2
    assert "nobody waits at" in out
    code, out = desk.gecos("join", link, "--as", "ben")
    assert code == 2
    assert re.search("say whose key it is", out)
