from __future__ import annotations

import json
import os
import pwd
import socket
from pathlib import Path

import gecos
import pytest
from command_output import Run, valid
from gecos.laboratory import LaboratoryFileError, read_laboratory
from robcl.device import DeviceServant
from robcl.frames import Frame

HOST = socket.gethostname()
ME = pwd.getpwuid(os.geteuid()).pw_name


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A lab file that admits anna to everything, and bob of another host, too, to RX90."""
    file = tmp_path / "lab.toml"
    file.write_text(
        '[allow]\nusers = ["anna"]\n[objects.RX90.allow]\nusers = ["bob"]\nhosts = ["bench1"]\n'
    )
    monkeypatch.setenv("GECOS_LAB_FILE", str(file))
    return file


def test_policy_names_the_rule_that_allows_or_denies(file: Path, run: Run) -> None:
    code, out, _ = run("policy", "test", "anna", HOST, "LDS")
    assert (code, out) == (
        0,
        f"allowed: LDS admits user anna of host {HOST}: named by [allow] in {file}:1\n",
    )
    code, out, _ = run("policy", "test", "anna", HOST, "RX90")
    assert (code, out) == (
        5,
        f"denied: RX90 refuses user anna of host {HOST}: [objects.RX90.allow] in {file}:3 does not "
        'name user anna; add "anna" to its users\n',
    )
    assert run("policy", "test", "bob", "bench1", "RX90")[0] == 0
    assert run("policy", "test", "bob", "desk", "RX90")[0] == 5


def test_policy_decides_for_a_server_of_this_user_or_another(file: Path, run: Run) -> None:
    assert run("policy", "test", ME, HOST, "RX90")[0] == 0
    assert run("policy", "test", "eve", HOST, "RX90")[0] == 5
    assert run("policy", "test", "eve", HOST, "RX90", "--server-user", "eve")[0] == 0


def test_policy_says_who_may_serve_an_object(file: Path, run: Run) -> None:
    file.write_text('[names]\nRX90 = "robcl@cell"\n')
    code, out, _ = run("policy", "test", "robcl", "cell", "RX90", "--serve")
    bound = f"[names] in {file}:2 binds this name to user robcl of host cell"
    assert (code, out) == (
        0,
        f"allowed: a server of user robcl of host cell may register RX90: {bound}\n",
    )
    code, out, _ = run("policy", "test", "anna", "cell", "RX90", "--serve")
    assert code == 5
    assert f"denied: a server of user anna of host cell may not register RX90: {bound}" in out
    assert run("policy", "test", "anna", "cell", "LDS", "--serve")[0] == 0


class Shelf(DeviceServant):
    """A device that stays where it is."""

    def base(self) -> Frame:
        return Frame()

    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None:
        raise gecos.Rejected("a shelf stays where it is")


def test_policy_says_which_status_the_operation_needs(
    server: gecos.Server, file: Path, run: Run
) -> None:
    server.add("SHELF", Shelf())
    code, out, _ = run("policy", "test", "anna", HOST, "SHELF", "mount")
    assert (code, out.splitlines()[1]) == (0, "mount needs actor status, for every caller")
    code, out, _ = run("policy", "test", "anna", HOST, "SHELF", "base")
    assert (code, out.splitlines()[1]) == (0, "base needs no status, for every caller")
    code, out, _ = run("policy", "test", "eve", HOST, "SHELF", "mount", "--json")
    assert code == 5
    assert valid(out, "policy test")
    assert not json.loads(out)["allowed"]
    assert json.loads(out)["status"] == "ACTOR"
    code, _, err = run("policy", "test", "anna", HOST, "SHELF", "turn")
    assert (code, err) == (2, "gecos: SHELF has no turn; its members are base, parent, mount\n")


def test_policy_refuses_a_file_with_an_error(file: Path, run: Run) -> None:
    file.write_text("[allow]\nuser = []\n")
    code, _, err = run("policy", "test", "anna", HOST, "LDS")
    assert (code, err) == (
        2,
        f"gecos: {file}:2: allow.user: this key is unknown; did you mean users?\n",
    )
    code, _, err = run("policy", "test", "anna", HOST, "LDS", "--file", str(file.with_name("no")))
    assert (code, err) == (2, f"gecos: {file.with_name('no')}: No such file or directory\n")


def test_gecos_up_refuses_the_same_errors_of_the_lists(file: Path) -> None:
    programs = '[programs.A]\nrun = ["a"]\n'
    file.write_text(programs)
    assert not read_laboratory(file).names_users
    file.write_text(programs + '[allow]\nusers = ["anna"]\n')
    assert read_laboratory(file).names_users
    file.write_text(programs + '[names]\nA = "anna@cell"\n')
    assert read_laboratory(file).names_users
    file.write_text(programs + '[allow]\nuser = ["anna"]\n')
    with pytest.raises(LaboratoryFileError) as refused:
        read_laboratory(file)
    assert str(refused.value) == (f"{file}:4: allow.user: this key is unknown; did you mean users?")


def test_names_of_users_are_a_list(server: gecos.Server) -> None:
    with pytest.raises(TypeError, match=r"users must be a list of names; write `users=\['anna'\]`"):
        server.allow("anna")
    server.allow(["anna"], hosts=["bench1"])


def test_a_program_names_at_most_256_users_and_hosts(server: gecos.Server) -> None:
    server.allow(["anna"] * 256, ["desk"] * 256)
    with pytest.raises(ValueError, match="at most 256 users and 256 hosts"):
        server.allow(["anna"] * 257)
