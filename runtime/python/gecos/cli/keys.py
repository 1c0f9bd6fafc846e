"""The verbs `gecos keys`, `keys add` and `keys remove`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from gecos.cli.exit_codes import ExitCode, UsageFailure
from gecos.cli.options import json_option, print_json

_EXCHANGE = """\
To reach objects of another user over lcm, exchange key files: send your file to the other user, and
add the file of that user by `gecos keys add FILE USER@HOST`. Then compare both fingerprints over
another channel, for example by telephone."""


@click.group(invoke_without_command=True)
@json_option
@click.pass_context
def keys(context: click.Context, as_json: bool) -> None:
    """Shows the key of this user, and the admitted keys of other users. The medium lcm uses these
    keys.

    Ends with 1 if the file of an admitted key cannot be used.
    """
    if context.invoked_subcommand is None:
        _show(as_json)
    elif as_json:  # written before the name of the verb below
        context.default_map = {context.invoked_subcommand: {"as_json": True}}


def _show(as_json: bool) -> None:
    from gecos import key_folder

    own = key_folder.own_key()
    admitted = key_folder.admitted()
    if as_json:
        shown = {
            "folder": str(key_folder.folder()),
            "own": _plain(own),
            "admitted": [_plain(one.key) | _state(one) for one in admitted],
        }
        print_json(shown)
    else:
        print(f"yours     {key_folder.fingerprint(own)}  {key_folder.file_of(own)}")
        for one in admitted:
            whose = f"  {one.owner}" if one.owner else ""
            print(f"admitted  {key_folder.fingerprint(one.key)}  {one.file}{whose}")
        print(_EXCHANGE)
    problems = [one.problem for one in admitted if one.problem]
    for problem in problems:
        print(f"gecos: {problem}", file=sys.stderr)
    if problems:
        sys.exit(ExitCode.ENVIRONMENT)


def _plain(key: str) -> dict[str, Any]:
    from gecos import key_folder

    return {
        "key": key,
        "fingerprint": key_folder.fingerprint(key),
        "file": str(key_folder.file_of(key)),
    }


def _state(of: Any) -> dict[str, Any]:
    return {"file": str(of.file), "problem": of.problem, "owner": of.owner}


@keys.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False, readable=False))
@click.argument("owner", metavar="[USER@HOST]", required=False)
@json_option
def add(file: Path, owner: str | None, as_json: bool) -> None:
    """Admits the user to whom the given .public file belongs.

    USER@HOST is the owner of the key: the lists of a lab file and of Server.allow then decide to
    which objects that user may connect. Leave USER@HOST out only for your own keys on other
    machines: such a key counts as another key of yours, which is admitted to everything.
    """
    from gecos import key_folder

    try:
        key = key_folder.add(file, owner)
    except key_folder.KeyFolderError as error:
        raise UsageFailure(str(error)) from None
    if as_json:
        print_json(_plain(key))
    else:
        print(
            f"admitted  {key_folder.fingerprint(key)}: compare this fingerprint with the one that "
            "`gecos keys` shows to the user of the key"
        )
        whose = key_folder.owner_of(key)
        if whose is not None:
            print(f"{whose} is admitted to the objects whose lists name {whose} (docs/security.md)")
        else:
            print(
                "this key has no owner: it is admitted to everything of yours, whatever the lists "
                "say; if it is the key of another user, run: "
                f"gecos keys add {key_folder.file_of(key)} USER@HOST"
            )


def _known(context: click.Context, _: click.Parameter, begun: str) -> list[CompletionItem]:
    """Returns the admitted keys, for the completion of a shell."""
    from gecos import key_folder

    try:
        found = key_folder.admitted()
    except (OSError, RuntimeError):
        return []
    return [CompletionItem(one.file.name) for one in found if one.file.name.startswith(begun)]


@keys.command()
@click.argument("name", shell_complete=_known)
@json_option
def remove(name: str, as_json: bool) -> None:
    """Removes an admitted key. NAME is the name of its file, or at least the first 8 digits of its
    fingerprint."""
    from gecos import key_folder

    try:
        gone = key_folder.remove(name)
    except key_folder.KeyFolderError as error:
        raise UsageFailure(str(error)) from None
    if as_json:
        print_json(_plain(gone.key) | {"file": str(gone.file)})
    else:
        print(f"removed   {gone.file}; sessions of that user end within 5 s")
