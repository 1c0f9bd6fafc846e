"""`gecos keys`: the key of this user, and the admitted ones."""

from __future__ import annotations

import json
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import pytest
from command_output import Run, valid

KEY = "9f3c21aa" * 8
OTHER = "71e0bb04" * 8


def key_text(key: str) -> str:
    """As docs/protocol.md, Keys."""
    text = f"gecos-public-1 {key} "
    return f"{text}{sha256(text.encode()).hexdigest()[:8]}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("GECOS_KEY_DIR", str(tmp_path / "keys"))
    return tmp_path / "keys"


@pytest.fixture
def received(tmp_path: Path) -> Path:
    """A file from another user."""
    file = tmp_path / "from-bob.public"
    file.write_text(key_text(KEY))
    return file


def test_the_own_key_is_made_and_shown(folder: Path, run: Run) -> None:
    code, out, err = run("keys")
    assert (code, err) == (0, "")
    own, *how = out.splitlines()
    (file,) = folder.glob("*.public")
    digits = file.name.removesuffix(".public")
    assert own == f"yours     {grouped(digits)}  {file}"
    assert "`gecos keys add FILE USER@HOST`" in " ".join(how)


def grouped(key: str) -> str:
    return ":".join(key[at : at + 4] for at in range(0, 32, 4))


def test_an_added_key_is_admitted_and_a_removed_one_is_not(
    folder: Path, received: Path, run: Run
) -> None:
    code, out, _ = run("keys", "add", str(received), "--json")
    assert code == 0
    assert valid(out, "keys add")
    place = folder / f"{KEY}.public"
    assert json.loads(out) == {"key": KEY, "fingerprint": grouped(KEY), "file": str(place)}
    assert place.stat().st_mode & 0o777 == 0o600
    assert run("keys", "--json", "add", str(received)) == (0, out, ""), "again"

    code, out, _ = run("keys", "--json")
    assert code == 0
    assert valid(out, "keys")
    (one,) = json.loads(out)["admitted"]
    assert (one["key"], one["problem"]) == (KEY, None)

    code, out, _ = run("keys", "remove", "9f3c:21aa", "--json")
    assert code == 0
    assert valid(out, "keys remove")
    assert not place.exists()
    assert not list(folder.glob(".new*"))


def test_a_key_without_an_owner_is_told_to_be_past_all_lists(
    folder: Path, received: Path, run: Run
) -> None:
    code, out, _ = run("keys", "add", str(received))
    assert code == 0
    assert "this key has no owner: it is admitted to everything of yours" in out
    assert f"gecos keys add {folder / KEY}.public USER@HOST" in out
    _, out, _ = run("keys", "add", str(received), "bob@desk")
    assert "no owner" not in out
    assert "bob@desk is admitted to the objects whose lists name bob@desk" in out
    _, out, _ = run("keys", "add", str(received))
    assert "bob@desk is admitted to the objects" in out, "the key keeps its owner"


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda text: text[:40], "is cut short"),
        (lambda text: "", "is empty"),
        (lambda text: text.replace("9f", "9e", 1), "is damaged (its checksum does not match)"),
        (lambda text: text * 2, "holds more than a key"),
        (lambda text: text.replace("public", "secret"), "this is a secret key"),
    ],
)
def test_a_file_that_is_no_key_is_not_admitted(
    folder: Path, received: Path, run: Run, change: Callable[[str], str], why: str
) -> None:
    received.write_text(change(received.read_text()))
    code, _, err = run("keys", "add", str(received))
    assert code == 2
    assert err.startswith(f"gecos: {received}: {why}")
    assert not folder.exists() or not (folder / f"{KEY}.public").exists()


def test_a_damaged_or_open_file_of_the_folder_is_told(
    folder: Path, received: Path, run: Run
) -> None:
    run("keys", "add", str(received))
    (folder / f"{OTHER}.public").write_text("damaged")
    (folder / f"{KEY}.public").chmod(0o666)
    (folder / "bob.public").write_text(key_text(OTHER))
    code, out, err = run("keys")
    assert code == 1
    assert out.count("admitted  ") == 3
    damaged, is_open, no_key = err.splitlines()  # in the order of the names of the files
    assert "is cut short: copy it again, or remove it" in damaged
    assert "is open to other users: run `chmod 600` on it" in is_open
    assert "bob.public: the name of this file is not a key of 64 hex digits" in no_key
    assert f"run `gecos keys add {folder / 'bob.public'} USER@HOST`" in no_key


def test_a_folder_that_others_can_read_is_refused(folder: Path, run: Run) -> None:
    folder.mkdir(mode=0o755)
    folder.chmod(0o755)
    code, out, err = run("keys")
    assert (code, out) == (1, "")
    why = "the key directory is open to other users: run `chmod 700` on it"
    assert err == f"gecos: {folder}: {why}\n"


def test_neither_the_own_key_nor_an_unknown_one_is_removed(folder: Path, run: Run) -> None:
    run("keys")
    (own,) = folder.glob("*.public")
    code, _, err = run("keys", "remove", own.name)
    assert code == 2
    assert err == f"gecos: {own.name}: this is your own key, which your programs need\n"
    code, _, err = run("keys", "remove", "01234567")
    assert code == 2
    assert (
        err
        == "gecos: 01234567: no admitted key has this name; `gecos keys` lists the admitted keys\n"
    )
    code, _, err = run("keys", "remove", "012")
    assert (code, err) == (2, "gecos: 012: give at least 8 digits of the fingerprint\n")


def test_a_file_that_cannot_be_read_says_why(folder: Path, run: Run, tmp_path: Path) -> None:
    missing = tmp_path / "missing.public"
    code, out, err = run("keys", "add", str(missing))
    assert (code, out) == (2, "")
    assert f"{missing}: No such file or directory" in err


def test_a_file_that_only_its_owner_may_read(
    folder: Path, run: Run, received: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refused)  # root, who runs the tests, may read every file
    code, out, err = run("keys", "add", str(received))
    assert (code, out) == (2, "")
    assert "ask its user for a copy that you may read" in err
