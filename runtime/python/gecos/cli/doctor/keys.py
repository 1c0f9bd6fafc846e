"""Checks whether this user has a key that programs can use."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from enum import Enum, auto

from gecos.cli.doctor.finding import Finding, fine, wrong

_ANOTHER = 'mkdir -m 700 "$HOME/.gecos-keys" && export GECOS_KEY_DIR="$HOME/.gecos-keys"'


class Kind(Enum):
    MISSING = auto()
    FOLDER = auto()
    FILE = auto()
    OTHER = auto()


@dataclass(frozen=True, slots=True)
class Place:
    """A path and what is there: nothing, a folder, a file or something else. `ours`: this user owns
    the file or folder. `shared`: other users may read or write the file or folder."""

    path: str
    kind: Kind
    ours: bool = True
    shared: bool = False
    readable: bool = True


def own_key(problem: str | None, folder: Place, file: Place) -> Finding:
    """Checks the key of this user. `problem` says why programs cannot use the key; None if they can
    use it. `file` is the file of the secret key in `folder`."""
    if problem is None:
        return fine("keys", "this user has a key", folder.path)
    return wrong("keys", problem, folder.path, _mend(folder, file))


def _mend(folder: Place, file: Place) -> str:
    if folder.kind is not Kind.FOLDER or not folder.ours:
        return _ANOTHER
    if folder.shared:
        return shlex.join(["chmod", "700", folder.path])
    if file.kind is Kind.MISSING or not file.ours:  # no key, or the key of another user
        return _ANOTHER
    if file.kind is Kind.FILE and (file.shared or not file.readable):
        return shlex.join(["chmod", "600", file.path])
    # `gecos keys` makes a new key, and says how users exchange it.
    return f"{shlex.join(['rm', '-r', file.path])} && gecos keys"
