from __future__ import annotations

import json
import os
import pwd
import socket
from pathlib import Path
from typing import Any

import gecos
import pytest
from command_output import Run, valid
from gecos import key_folder
from gecos.cli import policy
from gecos.dynamic_client import connect
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
    assert (code, out.splitlines()[0]) == (
        0,
        f"allowed: LDS admits user anna of host {HOST}: named by [allow] in {file}:1",
    )
    code, out, _ = run("policy", "test", "anna", HOST, "RX90")
    assert (code, out.splitlines()[0]) == (
        5,
        f"denied: RX90 refuses user anna of host {HOST}: [objects.RX90.allow] in {file}:3 does not "
        'name user anna; add "anna" to its users',
    )
    assert run("policy", "test", "bob", "bench1", "RX90")[0] == 0
    assert run("policy", "test", "bob", "desk", "RX90")[0] == 5


def test_policy_decides_for_a_server_of_this_user_or_another(file: Path, run: Run) -> None:
    assert run("policy", "test", ME, HOST, "RX90")[0] == 0
    assert run("policy", "test", "eve", HOST, "RX90")[0] == 5
    code, out, _ = run("policy", "test", "eve", HOST, "RX90", "--server-user", "eve")
    assert (code, len(out.splitlines())) == (0, 1)


def test_a_broker_of_root_admits_servers_of_the_user_gecos_only_if_its_file_names_them(
    file: Path, run: Run
) -> None:
    words = ("policy", "test", "gecos", HOST, "BROKER", "--server-user", "root")
    assert run(*words)[0] == 5
    file.write_text('[allow]\nusers = ["gecos", "anna"]\n')
    assert run(*words)[0] == 0


def test_policy_says_that_it_assumes_a_server_of_the_caller(file: Path, run: Run) -> None:
    code, out, _ = run("policy", "test", ME, HOST, "RX90")
    assert code == 0
    assumes, asked = out.splitlines()[1:]
    assert assumes == (
        f"this assumes that the server of RX90 runs as user {ME}, because no broker lists the "
        "object; name the user by --server-user"
    )
    assert asked.startswith("asked: RX90 was not reached: no broker answers; start ")


def test_policy_takes_the_user_of_the_server_from_the_broker(
    server: gecos.Server, file: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.add("RX90", Shelf())
    monkeypatch.setattr(key_folder, "this_user", lambda: "eve")  # who asks is of another user
    _, out, _ = run("policy", "test", "eve", HOST, "RX90", "--json")
    assert valid(out, "policy test")
    assert not json.loads(out)["allowed_by_file"]
    assert json.loads(out)["server"] == {"user": ME, "host": HOST, "known_from": "broker"}
    _, out, _ = run("policy", "test", "eve", HOST, "RX90")
    assert f"denied: RX90 refuses user eve of host {HOST}: [objects.RX90.allow]" in out
    assert f"\nthe server of RX90 runs as user {ME} of host {HOST}, as the broker says\n" in out


def test_policy_says_what_a_list_in_the_program_may_change(file: Path, run: Run) -> None:
    def told(user: str, name: str) -> str:
        return run("policy", "test", user, HOST, name)[1]

    of_file = "\nthis is what the file says; a list in the program of the server "
    assert of_file in told("anna", "LDS")
    assert told("anna", "LDS").endswith(", if there is such a list, must admit the user, too\n")
    assert of_file not in told("anna", "RX90")  # no program admits whom the file refuses
    file.write_text("")
    assert of_file in told("anna", "LDS")
    assert "may admit the user all the same, because no lab file has a list" in told("anna", "LDS")
    assert "before it was removed" not in told("anna", "LDS")
    assert of_file not in told(ME, "LDS")
    file.write_text('[objects.LDS.allow]\nusers = ["anna"]\n')
    assert "may admit the user all the same" in told("anna", "RX90")
    assert told("anna", "BROKER").startswith("allowed: ")
    assert "must admit the user, too" in told("anna", "BROKER")


def test_policy_without_a_file_says_that_servers_may_have_read_one(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GECOS_LAB_FILE", raising=False)
    monkeypatch.setattr(policy, "_OF_THIS_HOST", Path("/nonexistent/lab.toml"))
    code, out, _ = run("policy", "test", "anna", HOST, "LDS")
    assert code == 5
    assert "servers that have read a file before it was removed keep its lists" in out


def test_the_answer_of_the_object_counts_for_the_user_who_asks(
    server: gecos.Server, file: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.add("RX90", Shelf())
    code, out, _ = run("policy", "test", ME, HOST, "RX90")
    assert (code, out.splitlines()[0]) == (0, "allowed: RX90 admits this program (asked now)")
    fail_to_connect(monkeypatch, gecos.Attempt("RX90", gecos.Detail.REFUSED, "not in its list"))
    code, out, _ = run("policy", "test", ME, HOST, "RX90")
    assert (code, out.splitlines()[0]) == (5, "denied: not in its list (asked now)")
    assert out.splitlines()[1].startswith("the lab file alone says allowed: RX90 admits user ")
    code, out, _ = run("policy", "test", ME, HOST, "RX90", "--json")
    assert (code, valid(out, "policy test")) == (5, True)
    told = json.loads(out)
    assert (told["allowed"], told["allowed_by_file"], told["admitted"]) == (False, True, False)
    assert told["not_admitted"] == "not in its list"
    # A file or a user of a server that is only thought of is no matter for the object.
    assert run("policy", "test", ME, HOST, "RX90", "--server-user", ME)[0] == 0


def fail_to_connect(monkeypatch: pytest.MonkeyPatch, attempt: gecos.Attempt) -> None:
    """Lets connections to the object of `attempt` fail."""
    find = connect.find

    def failing(lab: gecos.Lab, name: str, **how: Any) -> gecos.Object:
        if name != attempt.name:
            return find(lab, name, **how)
        raise gecos.CreateError([attempt])

    monkeypatch.setattr(connect, "find", failing)


def test_an_object_that_is_online_and_not_reached_is_no_admission(
    server: gecos.Server, file: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.add("RX90", Shelf())
    attempt = gecos.Attempt("RX90", gecos.Detail.NO_SERVER, "the server does not answer")
    fail_to_connect(monkeypatch, attempt)
    code, out, _ = run("policy", "test", ME, HOST, "RX90")
    assert (code, out.splitlines()[0].partition(":")[0]) == (4, "allowed")
    assert out.splitlines()[-1] == "asked: RX90 was not reached: the server does not answer"
    code, out, _ = run("policy", "test", ME, HOST, "RX90", "--json")
    assert (code, valid(out, "policy test")) == (4, True)
    assert json.loads(out)["admitted"] is None
    assert json.loads(out)["not_admitted"] == "the server does not answer"


@pytest.mark.parametrize("user", [ME, "anna"])
def test_a_user_whom_the_broker_refuses_is_not_said_to_have_the_server(
    user: str, file: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    reason = "the broker refuses this program: shm:BROKER.sock: BROKER refuses you"
    refusal = gecos.CreateError([gecos.Attempt("BROKER", gecos.Detail.NO_SERVER, reason)])

    def refused(*_: Any, **__: Any) -> Any:
        raise refusal

    monkeypatch.setattr(gecos.Lab, "broker", refused)
    code, out, _ = run("policy", "test", user, HOST, "LDS")
    unknown = (
        "the user who runs the server of LDS is not known, because the broker refuses this "
        "program; name that user by --server-user"
    )
    if user == ME:
        assert (code, out.splitlines()) == (5, [f"denied: {reason} (asked now)", unknown])
    else:
        assert code == 0
        assert out.splitlines()[1] == unknown
    _, out, _ = run("policy", "test", user, HOST, "LDS", "--json")
    assert valid(out, "policy test")
    assert json.loads(out)["server"] is None


def test_the_object_is_asked_over_one_connection(
    server: gecos.Server, file: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.add("SHELF", Shelf())
    found: list[str] = []
    find = connect.find

    def counted(lab: gecos.Lab, name: str, **how: Any) -> gecos.Object:
        found.append(name)
        return find(lab, name, **how)

    monkeypatch.setattr(connect, "find", counted)
    assert run("policy", "test", ME, HOST, "SHELF", "mount")[0] == 0
    assert found == ["SHELF"]


def test_the_verdict_is_printed_where_the_object_cannot_be_asked_about_the_operation(
    lab: gecos.Lab, file: Path, run: Run
) -> None:
    code, out, err = run("policy", "test", "anna", HOST, "LDS", "move")
    assert code == 4
    assert out.startswith(f"allowed: LDS admits user anna of host {HOST}")
    assert err.startswith("gecos: which status move needs is not known: LDS: NO_SERVER: no such")
    code, out, _ = run("policy", "test", "eve", HOST, "LDS", "move", "--json")
    assert code == 5
    assert valid(out, "policy test")
    assert json.loads(out)["status_unknown"].startswith("LDS: NO_SERVER: no such object is online")


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
    code, _, err = run("policy", "test", "anna", "cell", "LDS", "move", "--serve")
    assert (code, err) == (
        2,
        "gecos: with --serve, only the name OBJECT is tested; leave out OPERATION\n",
    )


def test_policy_of_a_name_asks_nobody(
    file: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gecos, "Lab", None)
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
    assert (code, out.splitlines()[-1]) == (0, "mount needs actor status, for every caller")
    code, out, _ = run("policy", "test", "anna", HOST, "SHELF", "base")
    assert (code, out.splitlines()[-1]) == (0, "reading base needs no status, for every caller")
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
    assert not read_laboratory(file).tables_for_programs
    file.write_text(programs + '[allow]\nusers = ["anna"]\n')
    assert read_laboratory(file).tables_for_programs
    file.write_text(programs + '[names]\nA = "anna@cell"\n')
    assert read_laboratory(file).tables_for_programs == ("names",)
    file.write_text(programs + "[streams]\nopen = false\n[media.lcm]\nreal_time = true\n")
    assert read_laboratory(file).tables_for_programs == ("media", "streams")
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
