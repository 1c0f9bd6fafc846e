"""This user's key and the keys that this user admits: files of one folder, which lcm needs.

`gecos/crypto/key_directory.hpp` says what stands in the folder; its rules are asked for here.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from gecos import _core

_KEY = re.compile(r"[0-9a-f]{64}")
_SUFFIX = ".public"
_LONGEST_FILE = 4096  # bytes: more is no key
_LEAST_DIGITS = 8  # of a fingerprint that names a key
_FINGERPRINT_DIGITS = 32


class KeyFolderError(ValueError):
    """A file or a name that is no key, or not the one of an admitted key."""


@dataclass(frozen=True, slots=True)
class Admitted:
    """A file of the key folder. `problem`: why its key is not admitted; None if it is."""

    key: str
    file: Path
    problem: str | None


def folder() -> Path:
    return Path(_core.key_directory())


def own_key() -> str:
    """This user's public key, 64 hex digits; made at first use. Raises RuntimeError if the folder
    or the key is damaged, or other users can read or write it."""
    return _core.own_key()


def file_of(key: str) -> Path:
    return folder() / f"{key}{_SUFFIX}"


def fingerprint(key: str) -> str:
    """The first half of a key in groups, for people to compare: "9f3c:21aa:…"."""
    digits = key[:_FINGERPRINT_DIGITS]
    return ":".join(digits[at : at + 4] for at in range(0, len(digits), 4))


def admitted() -> list[Admitted]:
    """The keys beside this user's own, by name, also those whose files are damaged. Raises
    RuntimeError like own_key."""
    own = own_key()
    files = sorted(folder().glob(f"*{_SUFFIX}"))
    return [_judged(file) for file in files if file.name != own + _SUFFIX]


def _judged(file: Path) -> Admitted:
    key = file.name.removesuffix(_SUFFIX)
    if _KEY.fullmatch(key):
        return Admitted(key, file, _core.key_problem(key))
    mend = f"run `gecos keys add {file}`, and remove it"
    return Admitted("", file, f"{file}: its name is no key of 64 hex digits: {mend}")


def add(file: Path) -> str:
    """Admits the key in a .public file of another user, and returns the key. Raises KeyFolderError
    for a file that is no public key, OSError if it cannot be read or copied, RuntimeError like
    own_key."""
    with file.open("rb") as opened:
        text = opened.read(_LONGEST_FILE)
    if text.startswith(b"gecos-secret"):
        raise KeyFolderError(
            f"{file}: is a secret key, which never leaves its folder: take the .public file beside "
            "it, and a new key if somebody may have read this one"
        )
    try:
        key = _core.public_key_in(text)
    except ValueError as error:
        raise KeyFolderError(f"{file}: {error}: ask its user to copy it again") from None
    own_key()  # makes the folder
    _put(file_of(key), text)
    return key


def _put(place: Path, text: bytes) -> None:
    """Writes the whole file or none."""
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
    """Takes a key from the admitted ones; `name` is its file name, or the beginning of its
    fingerprint. Raises KeyFolderError if none or several have this name, or it is the own key."""
    own = own_key()
    wanted = Path(name).name
    digits = wanted.removesuffix(_SUFFIX).replace(":", "").lower()
    if len(digits) < _LEAST_DIGITS:
        raise KeyFolderError(f"{name}: give at least {_LEAST_DIGITS} digits of the fingerprint")
    if own.startswith(digits):
        raise KeyFolderError(f"{name}: is your own key, which your programs need")
    found = [one for one in admitted() if one.file.name == wanted or one.key.startswith(digits)]
    if len(found) != 1:
        how_many = "no admitted key has" if not found else f"{len(found)} admitted keys have"
        raise KeyFolderError(f"{name}: {how_many} this name; `gecos keys` lists them")
    found[0].file.unlink()
    return found[0]
