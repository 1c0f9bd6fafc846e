"""Lets a user of another machine join a laboratory without copying files.

The laboratory makes a link with its address, its public key and an invitation, which is a secret of
128 bits. The user sends the link to the other machine over a channel that no stranger can read. A
program there connects by TCP and sends its public key, the owner of the key and a proof: the
HMAC-SHA256 of both, with the invitation as key. The laboratory answers in the same way. Each side
then knows that the other side has the link, and that both keys arrived unchanged. An invitation
works once and expires.

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

from gecos import _core, key_folder

_URL = re.compile(
    r"gecos-join:(?P<host>[^/]+):(?P<port>\d{1,5})/(?P<key>[0-9a-f]{64})/(?P<secret>[0-9a-f]{32})"
)
_LONGEST_MESSAGE = 4096  # bytes
_ASKS_WITHIN = 2.0  # s; a stranger who says nothing must not keep others from joining
_ANSWERS_WITHIN = 10.0  # s
_FOLDER = "joining"
ANOTHER = "ask for a new link: `gecos lab init` prints it"


class EnrolmentError(ValueError):
    """An enrolment failed; the text says why and what to do."""


@dataclass(frozen=True, slots=True)
class JoinUrl:
    """The link that a laboratory gives to one user. It contains the address at which the laboratory
    waits for the user, the key of the laboratory, and the secret that both sides prove to have."""

    host: str
    port: int
    key: str
    secret: bytes

    def __str__(self) -> str:
        return f"gecos-join:{self.host}:{self.port}/{self.key}/{self.secret.hex()}"

    @classmethod
    def parse(cls, text: str) -> JoinUrl:
        found = _URL.fullmatch(text.strip())
        if found is None or int(found["port"]) > 65535:
            raise EnrolmentError(f"this is not a whole link; {ANOTHER}")
        secret = bytes.fromhex(found["secret"])
        return cls(found["host"], int(found["port"]), found["key"], secret)


@dataclass(frozen=True, slots=True)
class Party:
    """A key and its owner."""

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
        """Returns the user who has joined, and stores the request to join for `approve`. `owner` is
        this user. Clients without the right invitation are refused, with the reason. Raises
        EnrolmentError when the invitation has expired, and OSError if this host cannot accept the
        client or store the request."""
        while (left := self._end - time.monotonic()) > 0:
            self._listener.settimeout(left)
            try:
                line, _ = self._listener.accept()
            except (TimeoutError, ConnectionError):
                continue
            with line:
                party = self._hear(line, owner)
                if party is None:
                    continue
                _keep(party)
                self._listener.close()  # the link works once
                with contextlib.suppress(OSError):  # without the answer, that user asks again
                    _send(line, _signed(self.url, Party(self.url.key, owner), "lab"))
                return party
        raise EnrolmentError("nobody joined while the invitation was valid; make a new one")

    def _hear(self, line: socket.socket, owner: str) -> Party | None:
        """Returns the user who asks to join; None if the client is refused or lost."""
        with contextlib.suppress(OSError):
            said = _receive(line, _ASKS_WITHIN)
            party = Party(said.get("key", ""), said.get("owner", ""))
            why = self._refusal(said, party, owner)
            if why is None:
                return party
            _send(line, {"refused": why})
        return None

    def _refusal(self, said: dict[str, str], party: Party, owner: str) -> str | None:
        if not _proved(said, self.url, party, "join"):
            return f"this link does not belong to an invitation of this laboratory; {ANOTHER}"
        if party.key == self.url.key:
            return "you have the laboratory's own key, which needs no invitation"
        if not _core.is_key_owner(party.owner):
            return "say whose key it is by --as USER@HOST"
        if party.owner == owner or key_folder.is_own_user(party.owner):
            return (
                f"{party.owner} is admitted to everything here, so it cannot be your name; give "
                "your user and host by --as USER@HOST"
            )
        return None


def join(url: JoinUrl, owner: str) -> Party:
    """Asks the laboratory of `url` to admit this user as `owner`. Returns the key of the laboratory
    and the owner that it claims; the key is not admitted yet. Raises EnrolmentError if the
    laboratory refuses, or if the program at this address is not the laboratory of the link."""
    try:
        with socket.create_connection((url.host, url.port), _ANSWERS_WITHIN) as line:
            _send(line, _signed(url, Party(key_folder.own_key(), owner), "join"))
            said = _receive(line, _ANSWERS_WITHIN)
    except (OSError, UnicodeError) as error:  # a UnicodeError if url.host is not a host name
        where = f"{url.host}:{url.port}"
        raise EnrolmentError(
            f"nobody waits at {where} ({error}): the link was used, or has expired, or a firewall "
            f"blocks the connection; {ANOTHER}"
        ) from None
    if "refused" in said:
        raise EnrolmentError(said["refused"][:500])
    laboratory = Party(said.get("key", ""), said.get("owner", ""))
    if laboratory.key != url.key or not _proved(said, url, laboratory, "lab"):
        raise EnrolmentError(f"the answer is not from the laboratory of the link; {ANOTHER}")
    if laboratory.owner == owner:
        raise EnrolmentError(
            f"you and the user of the laboratory are both called {owner}; give yourself another "
            "name by --as USER@HOST"
        )
    return laboratory


def admit(party: Party) -> None:
    """Admits a key that came over the network. Raises EnrolmentError if the owner is this user, or
    if the owner already has another admitted key."""
    for one in key_folder.admitted():
        if one.owner == party.owner and one.key != party.key:
            raise EnrolmentError(
                f"{party.owner} has another key here, {key_folder.fingerprint(one.key)}: if it is "
                f"old, run `gecos revoke {party.owner}` first"
            )
    try:
        key_folder.admit(party.key, party.owner)
    except key_folder.KeyFolderError as error:
        raise EnrolmentError(str(error)) from None


def requests() -> list[Party]:
    """Returns the users who have joined and wait for `approve`. Raises EnrolmentError for a damaged
    file."""
    found = []
    for file in sorted((key_folder.folder() / _FOLDER).glob("*.owner")):
        try:
            party = Party(file.stem, file.read_text(encoding="ascii").strip())
        except UnicodeDecodeError:
            party = Party("", "")
        if not re.fullmatch(r"[0-9a-f]{64}", party.key) or not _core.is_key_owner(party.owner):
            raise EnrolmentError(f"{file}: this file is not a valid request to join; remove it")
        found.append(party)
    return found


def approve(name: str) -> Party:
    """Admits the key whose owner is `name`, or whose fingerprint begins with `name`."""
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
    admit(found[0])
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


def _signed(url: JoinUrl, party: Party, role: str) -> dict[str, str]:
    return {"key": party.key, "owner": party.owner, "proof": _proof(url, party, role)}


def _proved(said: dict[str, str], url: JoinUrl, party: Party, role: str) -> bool:
    whole = re.fullmatch(r"[0-9a-f]{64}", party.key) is not None
    given = said.get("proof", "").encode()
    return whole and hmac.compare_digest(given, _proof(url, party, role).encode())


def _send(line: socket.socket, message: dict[str, str]) -> None:
    line.sendall(json.dumps(message).encode() + b"\n")


def _receive(line: socket.socket, within: float) -> dict[str, str]:
    """Returns the fields of the next message, as printable texts by their names; an empty dict if
    the message is incomplete.
    Raises TimeoutError after `within` seconds. The peer has not proved its identity yet."""
    end = time.monotonic() + within
    text = b""
    while not text.endswith(b"\n") and len(text) < _LONGEST_MESSAGE:
        if (left := end - time.monotonic()) <= 0:
            raise TimeoutError(f"no complete message arrived within {within:g} s")
        line.settimeout(left)
        part = line.recv(_LONGEST_MESSAGE - len(text))
        if not part:
            break
        text += part
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    texts = message.items() if isinstance(message, dict) else ()
    return {name: one for name, one in texts if isinstance(one, str) and one.isprintable()}
