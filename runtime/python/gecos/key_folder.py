"""The key of this user, and the keys that this user admits. The keys are files of one folder, and
the medium lcm uses them.

`gecos/crypto/key_directory.hpp` describes the folder. This module calls the functions of that
header to check keys.
"""

from __future__ import annotations

import fcntl
import os
import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from gecos import _core

_KEY = re.compile(r"[0-9a-f]{64}")
_SUFFIX = ".public"
_OWNER_SUFFIX = ".owner"
_REVOKED = "revoked"
_LONGEST_FILE = 4096  # bytes; a longer file is not a key
_LEAST_DIGITS = 8  # of a fingerprint that selects a key
_FINGERPRINT_DIGITS = 32


class KeyFolderError(ValueError):
    """The given file is not a key, or the given name is not the name of an admitted key."""


@dataclass(frozen=True, slots=True)
class Admitted:
    """A file of the key folder. `problem` is the reason why its key is not admitted, or None if the
    key is admitted. `owner` is the owner of the key, such as "anna@desk". A key without an owner
    counts as a key of this user, so no list limits its access."""

    key: str
    file: Path
    problem: str | None
    owner: str | None = None


@dataclass(frozen=True, slots=True)
class Revoked:
    """A line of the file `revoked` of the key folder. The line revokes the key `key`, or, if `key`
    is empty, every key of `owner`. If `owner` is empty, `key` has no owner. The broker of this user
    tells the lines to all servers (gecos/access/revocations.hpp)."""

    key: str
    owner: str

    def line(self) -> str:
        return f"{self.key or '-'} {self.owner or '-'}\n"


def folder() -> Path:
    return Path(_core.key_directory())


def own_key() -> str:
    """Returns this user's public key as 64 hexadecimal digits, and makes the key at first use.
    Raises RuntimeError if the folder or the key is damaged, or if other users can read or write
    it."""
    return _core.own_key()


def file_of(key: str) -> Path:
    return folder() / f"{key}{_SUFFIX}"


def fingerprint(key: str) -> str:
    """Returns the first half of a key in groups of digits, for example "9f3c:21aa:…", for people to
    compare."""
    digits = key[:_FINGERPRINT_DIGITS]
    return ":".join(digits[at : at + 4] for at in range(0, len(digits), 4))


def admitted() -> list[Admitted]:
    """Returns the keys in the folder except this user's own, sorted by name, including keys whose
    files are damaged. Raises RuntimeError like own_key."""
    own = own_key()
    files = sorted(folder().glob(f"*{_SUFFIX}"))
    return [_judged(file) for file in files if file.name != own + _SUFFIX]


def _judged(file: Path) -> Admitted:
    key = file.name.removesuffix(_SUFFIX)
    if _KEY.fullmatch(key):
        problem = _core.key_problem(key)
        return Admitted(key, file, problem, owner_of(key))
    mend = f"run `gecos keys add {file} USER@HOST`, and remove it"
    return Admitted(
        "", file, f"{file}: the name of this file is not a key of 64 hex digits: {mend}"
    )


def owner_of(key: str) -> str | None:
    """Returns the owner of an admitted key, such as "anna@desk"; None if the key has no owner, or
    if the file of the owner cannot be read."""
    try:
        return _core.key_owner(key)
    except RuntimeError:  # `problem` has the reason
        return None


def add(file: Path, owner: str | None = None) -> str:
    """Admits the key in a .public file of another user, and returns the key. `owner` is the owner
    of the key, such as "anna@desk"; the lists of a lab file then decide what this user may do.
    Without `owner`, a key keeps the owner that it has. If the key or its owner was revoked, ends
    this revocation. Raises KeyFolderError if the file cannot be read or is not a public key,
    OSError if it cannot be copied, and RuntimeError like own_key."""
    if owner is not None and not _core.is_key_owner(owner):
        raise KeyFolderError(f"{owner}: say whose key it is as USER@HOST, for example anna@desk")
    try:
        with file.open("rb") as opened:
            text = opened.read(_LONGEST_FILE)
    except PermissionError:
        raise KeyFolderError(
            f"{file}: you may not read this file; ask its user for a copy that you may read"
        ) from None
    except OSError as error:
        raise KeyFolderError(f"{file}: {error.strerror}") from None
    if text.startswith(b"gecos-secret"):
        raise KeyFolderError(
            f"{file}: this is a secret key, which must never leave its folder: use the "
            ".public file "
            "beside it, and make a new key if somebody may have read this one"
        )
    try:
        key = _core.public_key_in(text)
    except ValueError as error:
        raise KeyFolderError(f"{file}: {error}: ask its user to copy it again") from None
    own = own_key()  # makes the folder if it is missing
    if owner is not None:
        if key == own:
            raise KeyFolderError(f"{file}: this is your own key, which needs no owner")
        if is_own_user(owner):
            raise KeyFolderError(
                f"{owner} is your own user on this host, who is admitted to all your objects, so "
                "no list would limit this key; name the owner as USER@HOST, with the host on which "
                "the owner uses the key"
            )
    with _alone():
        # The owner is written before the key, because no list limits a key without an owner.
        if owner is not None:
            _put(_owner_file(key), f"{owner}\n".encode())
        _put(file_of(key), text)
        _pardon(key, owner or owner_of(key) or "")
    return key


def is_own_user(owner: str) -> bool:
    """Returns whether `owner` is this user or root on this host. No list limits the access of these
    two users."""
    names = ("root", this_user())
    return owner in [f"{name}@{socket.gethostname()}" for name in names]


def this_user() -> str:
    """Returns the name of this user as it appears in lists and messages of servers."""
    import pwd

    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return f"uid {os.geteuid()}"


def admit(key: str, owner: str) -> None:
    """Admits a key of 64 hexadecimal digits, and stores its owner. Raises KeyFolderError and
    RuntimeError like add."""
    text = f"gecos-public-1 {key} "
    line = f"{text}{sha256(text.encode()).hexdigest()[:8]}\n".encode()
    with TemporaryDirectory() as place:
        file = Path(place) / f"{key}{_SUFFIX}"
        file.write_bytes(line)
        add(file, owner)


def _owner_file(key: str) -> Path:
    return folder() / f"{key}{_OWNER_SUFFIX}"


def _put(place: Path, text: bytes) -> None:
    """Writes the whole file, or leaves it unchanged."""
    fresh = place.with_name(f".new-{place.name[:8]}{os.getpid()}")
    descriptor = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    try:
        with os.fdopen(descriptor, "wb") as opened:
            opened.write(text)
            opened.flush()
            os.fsync(descriptor)
        fresh.replace(place)
    except OSError:
        fresh.unlink(missing_ok=True)
        raise


def remove(name: str) -> Admitted:
    """Ends the admission of a key. `name` is the name of its file, or the beginning of its
    fingerprint. Raises KeyFolderError if no key or several keys have this name, or if it is the
    user's own key."""
    own_key()  # makes the folder if it is missing
    with _alone():
        found = _named(name)
        _unlink(found)
    return found


def _named(name: str) -> Admitted:
    own = own_key()
    wanted = Path(name).name
    digits = wanted.removesuffix(_SUFFIX).replace(":", "").lower()
    found = [one for one in admitted() if one.file.name == wanted or one.key.startswith(digits)]
    if owned_by(name) and (not found or len(digits) < _LEAST_DIGITS):
        raise KeyFolderError(
            f"{name}: this is an owner; give the name of the file of one key, or at least "
            f"{_LEAST_DIGITS} digits of its fingerprint (`gecos keys` lists both), or run "
            f"`gecos revoke {name}`, which takes an owner"
        )
    if len(digits) < _LEAST_DIGITS:
        raise KeyFolderError(f"{name}: give at least {_LEAST_DIGITS} digits of the fingerprint")
    if own.startswith(digits):
        raise KeyFolderError(f"{name}: this is your own key, which your programs need")
    if len(found) != 1:
        how_many = "no admitted key has" if not found else f"{len(found)} admitted keys have"
        raise KeyFolderError(f"{name}: {how_many} this name; `gecos keys` lists the admitted keys")
    return found[0]


def _unlink(one: Admitted) -> None:
    one.file.unlink(missing_ok=True)
    if one.key:
        _owner_file(one.key).unlink(missing_ok=True)


def owned_by(name: str) -> list[Admitted]:
    """Returns the keys of an owner, "anna@desk", or of a user on all hosts, "anna"."""
    return [one for one in admitted() if _is_of(one, name)]


def revoked() -> list[Revoked]:
    """Returns the revocations, from old to new. Raises KeyFolderError if the file is damaged."""
    file = folder() / _REVOKED
    try:
        lines = file.read_text(encoding="ascii").splitlines()
    except FileNotFoundError:
        return []
    except (OSError, ValueError) as error:
        raise KeyFolderError(f"{file}: the file cannot be read: {error}") from None
    found = []
    for number, line in enumerate(lines, 1):
        key, _, owner = line.partition(" ")
        if not owner or not (key == "-" or _KEY.fullmatch(key)):
            raise KeyFolderError(
                f"{file}:{number}: this line is not a key and its owner; correct it"
            )
        found.append(Revoked(key.replace("-", ""), "" if owner == "-" else owner))
    return found


def _write_revoked(revocations: list[Revoked]) -> None:
    text = "".join(one.line() for one in revocations)
    _put(folder() / _REVOKED, text.encode("ascii"))


def _pardon(key: str, owner: str) -> None:
    """Removes the lines from the file `revoked` that revoke `key`, the owner `owner`, or the user
    of `owner` on all hosts."""
    owners = {owner, owner.partition("@")[0]} if owner else set()
    before = revoked()
    after = [
        one for one in before if one.key != key and not (one.key == "" and one.owner in owners)
    ]
    if after != before:
        _write_revoked(after)


def _note_revoked(news: list[Revoked]) -> None:
    before = revoked()
    _write_revoked([*(one for one in before if one not in news), *news])


@contextmanager
def _alone() -> Iterator[None]:
    """Waits until no other program adds, removes or revokes a key, and keeps other programs from
    doing so. Otherwise an admission could end a revocation that came after it, and a removal could
    leave a key without its owner. The folder must exist."""
    descriptor = os.open(folder(), os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def revocations_of(name: str, gone: list[Admitted]) -> list[Revoked]:
    """Returns the lines of the file `revoked` for the keys `gone`, which `revoke(name)` removes."""
    whole = [Revoked("", name)] if any(_is_of(one, name) for one in gone) else []
    return [*(Revoked(one.key, one.owner or "") for one in gone if one.key), *whole]


def _is_of(one: Admitted, name: str) -> bool:
    return one.owner is not None and name in (one.owner, one.owner.partition("@")[0])


def revoke(name: str) -> list[Admitted]:
    """Revokes all keys of the owner `name`, or the one key whose file name or whose beginning of
    the fingerprint is `name`. Removes the keys from the key folder, adds them to the file
    `revoked`, whose lines the broker tells to all servers, and returns the removed keys. Raises
    KeyFolderError if there is no such key, and RuntimeError like own_key."""
    own_key()  # makes the folder if it is missing
    with _alone():
        return _revoke(name)


def _revoke(name: str) -> list[Admitted]:
    found = owned_by(name)
    if not found and not re.fullmatch(r"[0-9a-fA-F:]+", name.removesuffix(_SUFFIX)):
        raise KeyFolderError(f"{name}: no admitted key has this owner; `gecos keys` lists them")
    found = found or [_named(name)]
    # The lines are written before the keys are removed. If this program is killed in between,
    # running it again completes the revocation.
    _note_revoked(revocations_of(name, found))
    for one in found:
        _unlink(one)
    return found
