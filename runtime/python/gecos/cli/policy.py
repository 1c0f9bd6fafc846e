"""The verb `gecos policy test`."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gecos.cli.exit_codes import ExitCode, UsageFailure
from gecos.cli.options import broker_option, json_option, print_json

if TYPE_CHECKING:
    from gecos.interface import Access

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
@click.option("--server-user", metavar="USER", help="User of the server; default: yours.")
@click.option("--serve", is_flag=True, help="Whether USER may serve OBJECT, by [names].")
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

    Decides by the lab file, for a server on this host. A list that a program gives to Server.allow
    is not known here. With OPERATION, asks OBJECT which status this operation needs; the lab file
    has no influence on the status. Ends with 0 if USER is allowed, and with 5 if not.
    """
    import socket

    from gecos import _core, key_folder

    path = file or named_file()
    text = "" if path is None else text_of(path)
    server = (server_user or key_folder.this_user(), socket.gethostname())
    try:
        who, shown = (user, host), str(path or "")
        if serve:
            allowed, rule = _core.may_register(text, shown, who, object_name)
        else:
            allowed, rule = _core.may_connect(text, shown, server, who, object_name)
    except ValueError as error:
        raise UsageFailure(str(error)) from None
    status = None if operation is None else _status_of(broker, object_name, operation)
    if as_json:
        needed = None if status is None else status.name
        print_json({"allowed": allowed, "rule": rule, "operation": operation, "status": needed})
    else:
        print(f"{'allowed' if allowed else 'denied'}: {rule}")
        if status is not None:
            print(f"{operation} needs {_words(status)}, for every caller")
    return ExitCode.FINISHED if allowed else ExitCode.NO_ACCESS


def _words(status: Access) -> str:
    return "no status" if status.name == "SENSOR" else f"{status.name.lower()} status"


def named_file() -> Path | None:
    """Returns the lab file that servers read if they are started in this environment, or None."""
    named = os.environ.get("GECOS_LAB_FILE")
    if named:
        return Path(named)
    return _OF_THIS_HOST if _OF_THIS_HOST.exists() else None


_LARGEST_FILE = 1 << 16  # bytes, as of a server


def text_of(path: Path) -> str:
    """Returns the text of a lab file. Raises UsageFailure if no server would read it."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            raise UsageFailure(f"{path}: this is not a file")
        if found.st_size > _LARGEST_FILE:
            raise UsageFailure(f"{path}: the file is larger than 64 KiB")
        if found.st_mode & stat.S_IWOTH:
            raise UsageFailure(f"{path}: everybody may write this file, so servers refuse it")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UsageFailure(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise UsageFailure(f"{path}: {error}") from None


def _status_of(broker: str | None, name: str, operation: str) -> Access:
    import gecos
    from gecos.dynamic_client import read_model
    from gecos.dynamic_client.connect import find, served_models, without_model

    with gecos.Lab(broker) as lab:
        found = find(lab, name)
        interface = gecos.describe(found).result().interface_name
        models = served_models(found)
    if not models:
        raise UsageFailure(without_model(name))
    members = {member.name: member for member in read_model(models, interface).members}
    if operation not in members:
        raise UsageFailure(f"{name} has no {operation}; its members are {', '.join(members)}")
    return members[operation].access
