"""The verb `gecos policy test`."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gecos.cli.exit_codes import ExitCode, UsageFailure, exit_code
from gecos.cli.options import broker_option, json_option, print_json

if TYPE_CHECKING:
    from gecos.cli.policy_asked import Answer, ServerUser
    from gecos.dynamic_client.model import Member

_OF_THIS_HOST = Path("/etc/gecos/lab.toml")


@click.group()
def policy() -> None:
    """Says who may connect to the objects of this host."""


@policy.command()
@click.argument("user")
@click.argument("host")
@click.argument("object_name", metavar="OBJECT")
@click.argument("operation", required=False)
@click.option(
    "--file",
    type=click.Path(path_type=Path),
    help="Lab file; default: GECOS_LAB_FILE, else /etc/gecos/lab.toml if it exists.",
)
@click.option(
    "--server-user",
    metavar="USER",
    help="User who runs the server; default: the user whom the broker names, else you.",
)
@click.option(
    "--serve", is_flag=True, help="Say whether [names] of the file lets USER serve OBJECT."
)
@broker_option
@json_option
def test(
    user: str,
    host: str,
    object_name: str,
    operation: str | None,
    file: Path | None,
    server_user: str | None,
    serve: bool,
    broker: str | None,
    as_json: bool,
) -> int:
    """Says whether USER on HOST may connect to OBJECT, and which rule decides this.

    Decides by the lab file of this host. This command does not know whether the program of the
    server has a list, too; if so, both lists must admit USER. If you are USER on HOST, this command
    also connects to OBJECT, and the answer of OBJECT counts. With OPERATION, asks OBJECT which
    status this operation or attribute needs; the lab file has no influence on the status. If
    OPERATION is an open stream, also says whether the lab file forbids to send it in clear. Asking
    leaves lines in the audits of OBJECT and the broker. Ends with 0 if USER is allowed, with 5 if
    not, and with 4 if the file allows USER but OBJECT, which the broker lists, is not reached.
    """
    import socket

    import gecos
    from gecos import _core, key_folder
    from gecos.cli import policy_asked

    if serve and operation is not None:
        raise UsageFailure("with --serve, only the name OBJECT is tested; leave out OPERATION")
    path = file or named_file()
    text = "" if path is None else text_of(path)
    who, here = (user, host), socket.gethostname()
    if serve:
        found = _may_serve(text, path, who, object_name)
        if as_json:
            _tell_json(found, None)
        else:
            _tell_verdict(found, object_name)
        return _code(found)
    with gecos.Lab(broker) as lab:
        if server_user is None:
            server = policy_asked.server_user(lab, object_name)
        else:
            server = policy_asked.ServerUser(server_user, here, policy_asked.KnownFrom.OPTION)
        found = _may_connect(text, path, server, who, object_name)
        if who == (key_folder.this_user(), here) and file is None and server_user is None:
            found.answer = policy_asked.answer(lab, object_name)
        if not as_json:
            _tell_verdict(found, object_name)
        if operation is not None:
            try:
                found.member = policy_asked.member(lab, object_name, operation, found.answer)
            except (ConnectionError, RuntimeError, ValueError) as error:
                found.unknown = error
    if found.member is not None:
        found.is_open = policy_asked.is_open(found.member)
        found.forbids_open = _core.forbids_open_streams(text, str(path or ""))
    if as_json:
        _tell_json(found, operation)
    if found.member is not None and not as_json:
        print("\n".join(policy_asked.needs(found.member)))
        if found.is_open:
            print(policy_asked.about_open_stream(found.member.name, found.forbids_open))
    if found.unknown is not None and not as_json:
        _tell_unknown(found.unknown, operation)
    return _code(found)


@dataclass(slots=True)
class _Found:
    """What the lab file says about a user and an object, and what the object has answered."""

    allowed_by_file: bool
    rule: str  # the rule of the lab file that decides, as a sentence
    # The user who runs the server of the object. None with --serve, because this option only asks
    # whether USER may serve an object of this name.
    server: ServerUser | None = None
    program: str = ""  # how a list in the program of the server may change the verdict
    answer: Answer | None = None  # what the object answered; None: the object was not asked
    member: Member | None = None
    unknown: Exception | None = None  # the reason why the member is not known
    is_open: bool = False  # whether the member is an open stream
    forbids_open: str = ""  # where the lab file forbids open streams

    @property
    def admits(self) -> bool | None:
        """What the object has answered; None if it was not asked, or not reached."""
        return None if self.answer is None else self.answer.admits

    @property
    def allowed(self) -> bool:
        """The verdict: the answer of the object if there is one, else that of the lab file."""
        return self.allowed_by_file if self.admits is None else self.admits

    @property
    def not_reached(self) -> bool:
        """Whether the object, which the broker lists, was asked and not reached."""
        from gecos.cli.policy_asked import KnownFrom

        listed = self.server is not None and self.server.known_from is KnownFrom.BROKER
        return listed and self.answer is not None and self.admits is None


def _may_serve(text: str, path: Path | None, who: tuple[str, str], name: str) -> _Found:
    from gecos import _core

    try:
        return _Found(*_core.may_register(text, str(path or ""), who, name))
    except ValueError as error:
        raise UsageFailure(str(error)) from None


def _may_connect(
    text: str, path: Path | None, server: ServerUser, who: tuple[str, str], name: str
) -> _Found:
    from gecos import _core

    of = (server.user, server.host)
    try:
        found = _Found(*_core.may_connect(text, str(path or ""), of, who, name), server)
    except ValueError as error:
        raise UsageFailure(str(error)) from None
    if who in (of, ("root", server.host)):
        # A server always admits its own user and root of its host, so no list can change this.
        return found
    list_of_program = (
        "a list in the program of the server (`allow`, or `users` and `hosts` of `serve`)"
    )
    if not _has_list(text, name):
        found.program = (
            f"{list_of_program} may admit the user all the same, because no lab file has a list "
            f"for {name}"
        )
        if path is None:
            found.program += "; servers that have read a file before it was removed keep its lists"
    elif found.allowed_by_file:
        found.program = f"{list_of_program}, if there is such a list, must admit the user, too"
    return found


def _has_list(text: str, name: str) -> bool:
    """Returns whether a lab file without errors has a list for an object."""
    import tomllib

    file = tomllib.loads(text)
    objects = file.get("objects", {})
    lists = [key for key, table in objects.items() if "allow" in table]
    return "allow" in file or name in lists or (name == "BROKER" and bool(lists))


def _tell_verdict(found: _Found, name: str) -> None:
    """Prints the verdict, the rule that decided it, and the assumptions on which the verdict
    depends."""
    from gecos.cli.report import printable

    for line in _verdict(found, name):
        print(printable(line), flush=True)


def _verdict(found: _Found, name: str) -> Iterator[str]:
    from gecos.cli.policy_asked import KnownFrom

    server, answer = found.server, found.answer
    if answer is None or answer.admits is None:
        yield f"{_word(found.allowed)}: {found.rule}"
    else:
        why = answer.reason or f"{name} admits this program"
        yield f"{_word(found.allowed)}: {why} (asked now)"
        if server is not None and server.known_from is not KnownFrom.UNKNOWN:
            yield f"the lab file alone says {_word(found.allowed_by_file)}: {found.rule}"
    if server is not None:
        yield from _about_server(server, name)
    if answer is not None and answer.admits is None:
        yield f"asked: {name} was not reached: {answer.reason}"
    if found.admits is None and found.program:
        yield f"this is what the file says; {found.program}"


def _word(allowed: bool) -> str:
    return "allowed" if allowed else "denied"


def _about_server(server: ServerUser, name: str) -> Iterator[str]:
    """Yields sentences that say which user runs the server of an object, as far as this is
    known."""
    import socket

    from gecos.cli.policy_asked import KnownFrom

    match server.known_from:
        case KnownFrom.BROKER:
            whose = f"user {server.user} of host {server.host}"
            yield f"the server of {name} runs as {whose}, as the broker says"
            if server.host != socket.gethostname():
                yield f"that server reads the lab file of host {server.host}, not of this host"
        case KnownFrom.ASSUMED:
            yield (
                f"this assumes that the server of {name} runs as user {server.user}, because no "
                "broker lists the object; name the user by --server-user"
            )
        case KnownFrom.UNKNOWN:
            yield (
                f"the user who runs the server of {name} is not known, because the broker refuses "
                "this program; name that user by --server-user"
            )
        case KnownFrom.OPTION:
            pass


def _tell_json(found: _Found, operation: str | None) -> None:
    from gecos.cli import policy_asked

    called, set_ = (None, None) if found.member is None else policy_asked.statuses(found.member)
    server = found.server
    if server is not None and server.known_from is policy_asked.KnownFrom.UNKNOWN:
        server = None
    print_json(
        {
            "allowed": found.allowed,
            "allowed_by_file": found.allowed_by_file,
            "rule": found.rule,
            "server": None
            if server is None
            else {"user": server.user, "host": server.host, "known_from": server.known_from},
            "admitted": found.admits,
            "not_admitted": None if found.answer is None else found.answer.reason or None,
            "operation": operation,
            "status": called,
            "status_to_set": set_,
            "status_unknown": None if found.unknown is None else str(found.unknown),
            "sent_in_clear": None
            if found.member is None
            else found.is_open and not found.forbids_open,
        }
    )


def _tell_unknown(error: Exception, operation: str | None) -> None:
    from gecos.cli.report import printable

    why = str(error)
    if not isinstance(error, UsageFailure):
        why = f"which status {operation} needs is not known: {why}"
    print(printable(f"gecos: {why}"), file=sys.stderr)


def _code(found: _Found) -> int:
    """Returns the exit code. If the object refuses only to say which status an operation needs, the
    user may still be allowed, so the exit code is not NO_ACCESS."""
    if isinstance(found.unknown, UsageFailure):
        return ExitCode.USAGE
    if not found.allowed:
        return ExitCode.NO_ACCESS
    if found.unknown is None:
        return ExitCode.CONNECTION_FAILED if found.not_reached else ExitCode.FINISHED
    code = exit_code(found.unknown)
    return ExitCode.CONNECTION_FAILED if code is ExitCode.NO_ACCESS else code


def named_file() -> Path | None:
    """Returns the lab file that servers read if they are started in this environment, or None."""
    named = os.environ.get("GECOS_LAB_FILE")
    if named:
        return Path(named)
    return _OF_THIS_HOST if _OF_THIS_HOST.exists() else None


_LARGEST_FILE = 1 << 16  # bytes; servers refuse a larger lab file


def text_of(path: Path) -> str:
    """Returns the text of a lab file. Raises UsageFailure if no server would read it."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            raise UsageFailure(f"{path}: this is not a regular file")
        if found.st_size > _LARGEST_FILE:
            raise UsageFailure(f"{path}: the file is larger than 64 KiB")
        if found.st_mode & stat.S_IWOTH:
            raise UsageFailure(f"{path}: everybody may write this file, so servers refuse it")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UsageFailure(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise UsageFailure(f"{path}: {error}") from None
