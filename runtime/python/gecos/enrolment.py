"""How a user of another machine joins a laboratory without copying files.

The laboratory makes a link with its address, its public key and an invitation, which is a secret of
128 bits. The link goes to the other machine by a way on which no stranger reads. There a program
connects by TCP and sends its public key, its owner and a proof, which is the HMAC-SHA256 of both
under the invitation; the laboratory answers in the same way. So each side knows that the other one
has the link, and that nobody has changed a key on its way. An invitation works once and expires.

A request waits in the folder `joining` of the key folder until the user of the laboratory approves
it. Until then its key is not admitted.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import os
import re
import secrets
import socket
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gecos import _core, key_folder

_URL = re.compile(
    r"gecos-join:(?P<host>[^/]+):(?P<port>\d{1,5})/(?P<key>[0-9a-f]{64})/(?P<secret>[0-9a-f]{32})"
)
_LONGEST_MESSAGE = 4096  # bytes
_ANSWERS_WITHIN = 10.0  # s
_FOLDER = "joining"
ANOTHER = "ask for a new link: `gecos lab init` prints it"


class EnrolmentError(ValueError):
    """Somebody cannot join; the text says why and what to do."""


@dataclass(frozen=True, slots=True)
class JoinUrl:
    """Where a laboratory waits for somebody who joins, and by which secret it knows that one."""

    host: str
    port: int
    key: str
    secret: bytes

    def __str__(self) -> str:
        return f"gecos-join:{self.host}:{self.port}/{self.key}/{self.secret.hex()}"

    @classmethod
    def parse(cls, text: str) -> JoinUrl:
        found = _URL.fullmatch(text.strip())
        if found is None:
            raise EnrolmentError(f"this is not a whole link; {ANOTHER}")
        secret = bytes.fromhex(found["secret"])
        return cls(found["host"], int(found["port"]), found["key"], secret)


@dataclass(frozen=True, slots=True)
class Party:
    """A key, and whose it is."""

    key: str
    owner: str


class Invitation:
    """Waits at a port for one user who has the link. A context manager."""

    def __init__(self, host: str, port: int = 0, *, lives: float) -> None:
        self._listener = socket.create_server(("", port))
        self._end = time.monotonic() + lives
        self.url = JoinUrl(
            host, self._listener.getsockname()[1], key_folder.own_key(), secrets.token_bytes(16)
        )

    def __enter__(self) -> Invitation:
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()

    def wait(self, owner: str) -> Party:
        """Returns who has joined, and keeps the request for `approve`. `owner` is this user. Those
        without the right invitation are told so. Raises EnrolmentError when the time is over."""
        while (left := self._end - time.monotonic()) > 0:
            self._listener.settimeout(left)
            with contextlib.suppress(TimeoutError, OSError):
                line, _ = self._listener.accept()
                with line:
                    if (party := self._hear(line, owner)) is not None:
                        return party
        raise EnrolmentError("nobody joined while the invitation was valid; make a new one")

    def _hear(self, line: socket.socket, owner: str) -> Party | None:
        said = _receive(line)
        party = Party(str(said.get("key")), str(said.get("owner")))
        if not _proved(said, self.url, party, "join"):
            _send(line, {"refused": f"the invitation of this link is not known here; {ANOTHER}"})
            return None
        if not _core.is_key_owner(party.owner) or party.key == self.url.key:
            why = "say whose key it is by --as USER@HOST; with the same key, no link is needed"
            _send(line, {"refused": why})
            return None
        _keep(party)
        self._listener.close()  # the link works once
        _send(line, _signed(self.url, Party(self.url.key, owner), "lab"))
        return party


def join(url: JoinUrl, owner: str) -> Party:
    """Asks the laboratory of `url` to admit this user as `owner`, and admits the laboratory's key.
    Returns the laboratory. Raises EnrolmentError if it refuses or is not the one of the link."""
    try:
        with socket.create_connection((url.host, url.port), _ANSWERS_WITHIN) as line:
            _send(line, _signed(url, Party(key_folder.own_key(), owner), "join"))
            said = _receive(line)
    except OSError as error:
        where = f"{url.host}:{url.port}"
        raise EnrolmentError(
            f"nobody waits at {where} ({error}): the link was used, or has expired, or a firewall "
            f"is between; {ANOTHER}"
        ) from None
    if "refused" in said:
        raise EnrolmentError(str(said["refused"])[:500])
    laboratory = Party(str(said.get("key")), str(said.get("owner")))
    if laboratory.key != url.key or not _proved(said, url, laboratory, "lab"):
        raise EnrolmentError(f"the answer is not from the laboratory of the link; {ANOTHER}")
    key_folder.admit(laboratory.key, laboratory.owner)
    return laboratory


def requests() -> list[Party]:
    """Returns who has joined and waits for `approve`."""
    found = []
    for file in sorted((key_folder.folder() / _FOLDER).glob("*.owner")):
        found.append(Party(file.stem, file.read_text(encoding="utf-8").strip()))
    return found


def approve(name: str) -> Party:
    """Admits the user whose owner, or beginning of the fingerprint, is `name`."""
    digits = name.replace(":", "").lower()
    found = [
        one
        for one in requests()
        if name == one.owner or (len(digits) >= 8 and one.key.startswith(digits))
    ]
    if len(found) != 1:
        how_many = "nobody" if not found else f"{len(found)} keys"
        waiting = ", ".join(f"{one.owner} {key_folder.fingerprint(one.key)}" for one in requests())
        raise EnrolmentError(
            f"{name}: {how_many} of this name asked to join; waiting: {waiting or 'nobody'}"
        )
    key_folder.admit(found[0].key, found[0].owner)
    _file_of(found[0].key).unlink()
    return found[0]


def _file_of(key: str) -> Path:
    return key_folder.folder() / _FOLDER / f"{key}.owner"


def _keep(party: Party) -> None:
    file = _file_of(party.key)
    file.parent.mkdir(mode=0o700, exist_ok=True)
    descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as opened:
        opened.write(f"{party.owner}\n")


def _proof(url: JoinUrl, party: Party, role: str) -> str:
    text = "\n".join(("gecos enrolment 1", role, url.key, party.key, party.owner))
    return hmac.new(url.secret, text.encode(), "sha256").hexdigest()


def _signed(url: JoinUrl, party: Party, role: str) -> dict[str, Any]:
    return {"key": party.key, "owner": party.owner, "proof": _proof(url, party, role)}


def _proved(said: dict[str, Any], url: JoinUrl, party: Party, role: str) -> bool:
    whole = re.fullmatch(r"[0-9a-f]{64}", party.key) is not None
    given = str(said.get("proof")).encode()
    return whole and hmac.compare_digest(given, _proof(url, party, role).encode())


def _send(line: socket.socket, message: dict[str, Any]) -> None:
    line.sendall(json.dumps(message).encode() + b"\n")


def _receive(line: socket.socket) -> dict[str, Any]:
    """Returns the next message; an empty one if it does not come whole and in time."""
    end = time.monotonic() + _ANSWERS_WITHIN
    text = b""
    while not text.endswith(b"\n") and len(text) < _LONGEST_MESSAGE:
        line.settimeout(max(0.01, end - time.monotonic()))
        part = line.recv(_LONGEST_MESSAGE - len(text))
        if not part:
            break
        text += part
    try:
        message = json.loads(text)
    except ValueError:
        return {}
    return message if isinstance(message, dict) else {}
