"""`gecos revoke`, and the owners of keys."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from pathlib import Path

import gecos
import pytest
from command_output import Run, valid
from gecos import key_folder
from gecos_idl.broker import Broker
from shelf import Shelf

KEY = "9f3c21aa" * 8
OTHER = "71e0bb04" * 8
HOST = socket.gethostname()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("GECOS_KEY_DIR", str(tmp_path / "keys"))
    monkeypatch.setenv("GECOS_LAB_FILE", str(tmp_path / "lab.toml"))
    (tmp_path / "lab.toml").touch(0o644)
    return tmp_path / "keys"


def received(place: Path, key: str) -> str:
    """A .public file as docs/protocol.md describes it, Keys."""
    text = f"gecos-public-1 {key} "
    file = place / f"{key[:4]}.public"
    file.write_text(f"{text}{sha256(text.encode()).hexdigest()[:8]}\n")
    return str(file)


def test_the_owner_of_a_key_is_shown_kept_and_removed_with_it(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    file = received(tmp_path, KEY)
    assert run("keys", "add", file, "anna@desk")[0] == 0
    assert (folder / f"{KEY}.owner").stat().st_mode & 0o777 == 0o600
    assert run("keys", "add", file)[0] == 0, "without a name, it keeps the one that it has"
    _, out, _ = run("keys", "--json")
    assert valid(out, "keys")
    assert [one["owner"] for one in json.loads(out)["admitted"]] == ["anna@desk"]
    assert run("keys")[1].splitlines()[1].endswith("  anna@desk")
    assert run("keys", "remove", KEY[:8])[0] == 0
    assert [file.name for file in folder.iterdir() if KEY in file.name] == []


@pytest.mark.parametrize("name", ["anna@pc", "anna"])
def test_remove_of_an_owner_says_what_it_takes_and_what_takes_an_owner(
    folder: Path, tmp_path: Path, run: Run, name: str
) -> None:
    assert run("keys", "add", received(tmp_path, KEY), "anna@pc")[0] == 0
    assert run("keys", "remove", name) == (
        2,
        "",
        f"gecos: {name}: this is an owner; give the name of the file of one key, or at least 8 "
        "digits of its fingerprint (`gecos keys` lists both), or run "
        f"`gecos revoke {name}`, which takes an owner\n",
    )
    assert (folder / f"{KEY}.public").exists()


@pytest.mark.parametrize("owner", ["anna", "@desk", "anna@", "an na@desk", "a@b@c", 'a"@b'])
def test_a_text_that_is_no_owner_is_refused(
    folder: Path, tmp_path: Path, run: Run, owner: str
) -> None:
    code, _, err = run("keys", "add", received(tmp_path, KEY), owner)
    assert code == 2
    assert f"{owner}: say whose key it is as USER@HOST, for example anna@desk" in err
    assert not (folder / f"{KEY}.public").exists()


def test_a_key_whose_owner_is_damaged_is_not_admitted(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    run("keys", "add", received(tmp_path, KEY), "anna@desk")
    (folder / f"{KEY}.owner").write_text("anna\n")
    code, _, err = run("keys")
    assert code == 1
    assert "does not name the owner of the key" in err


def test_revoke_takes_all_keys_of_a_user_and_names_the_servers_that_act(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    run("keys", "add", received(tmp_path, KEY), "anna@desk")
    run("keys", "add", received(tmp_path, OTHER), "anna@bench")
    with gecos.Lab() as lab, gecos.Broker(lab), gecos.Server(lab) as server:
        server.add("SHELF", Shelf())
        code, out, err = run("revoke", "anna", "--json")
    assert (code, err) == (0, "")
    assert valid(out, "revoke")
    told = json.loads(out)
    assert {one["owner"] for one in told["removed"]} == {"anna@desk", "anna@bench"}
    assert (told["reached"], told["missed"]) == (["SHELF"], [])
    assert not list(folder.glob(f"{KEY}*")) and not list(folder.glob(f"{OTHER}*"))


def test_revoke_names_the_list_that_still_admits_the_user_and_ends_with_3(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    (tmp_path / "lab.toml").write_text('[allow]\nusers = ["anna"]\n')
    with gecos.Lab() as lab, gecos.Broker(lab):
        code, out, err = run("revoke", "anna")
    assert (code, out) == (3, "")
    assert f"BROKER admits user anna of host {HOST}: named by [allow]" in err
    assert "remove the name there, too" in err


def test_the_broker_of_the_user_tells_the_revocations_and_a_new_admission_ends_them(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    anna, other = received(tmp_path, KEY), received(tmp_path, OTHER)
    run("keys", "add", anna, "anna@desk")
    run("keys", "add", other, "anna@bench")
    with gecos.Lab() as lab, gecos.Broker(lab):
        broker = lab.broker(Broker)
        assert broker.revocations(0).result().number == 0
        run("revoke", "anna@desk")
        run("revoke", OTHER[:8])
        told = broker.revocations(0).result()
        assert told.changed
        assert [(one.key, one.owner) for one in told.revoked] == [
            (KEY, "anna@desk"),
            ("", "anna@desk"),
            (OTHER, "anna@bench"),
        ]
        again = broker.revocations(told.number).result()
        assert (again.number, again.changed, again.revoked) == (told.number, False, [])
        run("keys", "add", anna, "anna@desk")
        run("keys", "add", other, "anna@bench")
        assert broker.revocations(told.number).result().revoked == []


def test_a_damaged_list_of_revocations_is_an_error_with_its_line(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    run("keys", "add", received(tmp_path, KEY), "anna@desk")
    (folder / "revoked").write_text("anna@desk\n")
    with gecos.Lab() as lab, gecos.Broker(lab):
        with pytest.raises(gecos.CommandFailed, match="line 1 must be a key"):
            lab.broker(Broker).revocations(0).result()
        code, _, err = run("revoke", "anna@desk")
    assert code == 2
    assert "revoked:1: this line is not a key and its owner; correct it" in err
    assert (folder / f"{KEY}.public").exists(), "the list comes first"


@pytest.mark.parametrize("name", ["anna@desk", KEY[:8]])
def test_a_revocation_that_was_killed_half_way_is_completed_by_the_next_one(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def killed(_: key_folder.Admitted) -> None:
        raise InterruptedError

    key_folder.add(Path(received(tmp_path, KEY)), "anna@desk")
    with monkeypatch.context() as patch:
        patch.setattr(key_folder, "_unlink", killed)
        with pytest.raises(InterruptedError):
            key_folder.revoke(name)
    assert [one.key for one in key_folder.revoked() if one.key] == [KEY]
    assert [one.key for one in key_folder.revoke(name)] == [KEY]
    assert [one.key for one in key_folder.revoked() if one.key] == [KEY]
    assert key_folder.admitted() == []


def test_admissions_removals_and_revocations_never_run_at_the_same_time(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise an admission could end a revocation that came after it, and a removal could leave a
    key without its owner."""
    put, unlink, locked = key_folder._put, key_folder._unlink, []

    def note_lock() -> None:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            locked.append(True)
        else:
            locked.append(False)
        finally:
            os.close(descriptor)

    def put_noting(place: Path, text: bytes) -> None:
        note_lock()
        put(place, text)

    def unlink_noting(one: key_folder.Admitted) -> None:
        note_lock()
        unlink(one)

    monkeypatch.setattr(key_folder, "_put", put_noting)
    monkeypatch.setattr(key_folder, "_unlink", unlink_noting)
    key_folder.add(Path(received(tmp_path, KEY)), "anna@desk")
    key_folder.revoke("anna@desk")
    assert locked == [True] * 4, "the owner, the key, the list, and the removal of the key"
    locked.clear()
    key_folder.add(Path(received(tmp_path, KEY)), "anna@desk")
    key_folder.remove(KEY)
    assert locked == [True] * 4, "the owner, the key, the list, and the removal of the key"


def test_revocations_at_the_same_time_lose_no_line(folder: Path, tmp_path: Path) -> None:
    owners = {f"{number:08x}" * 8: f"anna@desk{number}" for number in range(16)}
    for key, owner in owners.items():
        key_folder.add(Path(received(tmp_path, key)), owner)
    with ThreadPoolExecutor(len(owners)) as pool:
        list(pool.map(key_folder.revoke, owners.values()))
    assert {one.key for one in key_folder.revoked() if one.key} == set(owners)


def test_revoke_of_nobody_says_what_it_takes(folder: Path, run: Run) -> None:
    code, _, err = run("revoke", "anna@nowhere")
    assert code == 2
    assert "no admitted key has this owner" in err


def test_revoke_without_a_broker_removes_the_key_and_says_that_servers_are_not_known(
    folder: Path, tmp_path: Path, run: Run
) -> None:
    run("keys", "add", received(tmp_path, KEY), "anna@desk")
    code, out, err = run("revoke", "anna@desk")
    assert code == 3
    assert out.startswith("removed ")
    assert "the broker lists no servers, so servers of other users were not reached" in err
    assert not (folder / f"{KEY}.public").exists()
