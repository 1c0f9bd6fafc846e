"""The start of the command line, and what it prints when a verb fails.

Imports take most of the time of a short command. Therefore the module of a verb is imported only
when the verb is used, and the function of the verb imports the modules that only this verb needs.
"""

from __future__ import annotations

import contextlib
import os
import sys
from importlib import import_module
from typing import TextIO

import click

from gecos.cli.exit_codes import (
    ExitCode,
    InterruptedCommand,
    UsageFailure,
    exit_code,
    failure_json,
)
from gecos.cli.options import print_json

_VERBS = {
    "approve": "enrol.approve",
    "break": "break_status.break_status",
    "broker": "broker.broker",
    "call": "members.call",
    "completion": "completion.completion",
    "describe": "describe.describe",
    "doctor": "doctor.verb.doctor",
    "events": "events.events",
    "explain": "explain.explain",
    "free": "free.free",
    "get": "members.get",
    "holders": "holders.holders",
    "hz": "members.hz",
    "join": "enrol.join",
    "keys": "keys.keys",
    "lab": "enrol.lab",
    "ls": "ls.ls",
    "plot": "plot.verb.plot",
    "policy": "policy.policy",
    "revoke": "revoke.revoke",
    "schema": "schema.schema",
    "set": "members.set_",
    "stats": "stats.stats",
    "stop": "stop.stop",
    "up": "up.up",
    "wait": "wait.wait",
    "watch": "members.watch",
    "why": "why.why",
}
"""Maps each verb to its module and the name of its function."""

_WITHOUT_OUTPUT = ("broker", "stop", "up")
"""The verbs that also run without standard output. A stop must never fail for this reason; the
other two are daemons."""


class Verbs(click.Group):
    """The verbs of `_VERBS`. The module of a verb is imported when the verb is used."""

    def list_commands(self, context: click.Context) -> list[str]:
        return sorted(_VERBS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in _VERBS:
            return None
        module, _, function = _VERBS[name].rpartition(".")
        verb: click.Command = getattr(import_module(f"gecos.cli.{module}"), function)
        return verb

    def resolve_command(
        self, context: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] not in _VERBS and not context.resilient_parsing:  # a completion must not fail
            from difflib import get_close_matches

            near = get_close_matches(args[0], _VERBS, n=1)
            if near:
                context.fail(f"No such command '{args[0]}'; did you mean {near[0]}?")
        return super().resolve_command(context, args)


def _print_version(context: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        print(f"gecos {_version()}")
        context.exit()


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("robcl")
    except PackageNotFoundError:
        return "(unknown: robcl is not installed, this is a source tree)"


@click.group(cls=Verbs, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Print the version and exit.",
)
def app() -> None:
    """Shows, calls and stops the objects of a robot laboratory, and runs a broker.

    Exit codes: 0 FINISHED, 1 the environment is wrong, 2 wrong usage, 3 COMMAND_FAILED, 4
    CONNECTION_FAILED, 5 access DENIED or REFUSED (instead of 3 and 4), 130 Ctrl-C.
    """


def run() -> int:
    """Runs the command line and returns the exit code. A failure is printed in one line."""
    if not _has_streams():
        print("gecos: standard output is closed; nothing was done", file=sys.stderr)
        return ExitCode.ENVIRONMENT
    try:
        _refuse_bytes()
        code = app(prog_name="gecos", standalone_mode=False)
    except click.exceptions.Exit as end:
        return end.exit_code
    except SystemExit as end:
        return int(end.code or 0)
    except (click.ClickException, click.Abort, OSError, RuntimeError, ValueError) as error:
        _tell(error)
        return exit_code(error)
    return code if isinstance(code, int) else ExitCode.FINISHED


def _has_streams() -> bool:
    """Replaces standard error, if it was closed before gecos started, by one that discards its
    text: Python has None in place of a closed stream, and would print the text on standard output.
    Does the same with standard output for the verbs of _WITHOUT_OUTPUT; for any other verb, returns
    False if standard output is closed."""
    if sys.stderr is None:
        sys.stderr = _nowhere()
    if sys.stdout is None:
        verb = next((word for word in sys.argv[1:] if not word.startswith("-")), "")
        if verb not in _WITHOUT_OUTPUT:
            return False
        sys.stdout = _nowhere()
    return True


def _nowhere() -> TextIO:
    return os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8", errors="replace")


def _refuse_bytes() -> None:
    """Raises UsageFailure if an argument or the password in the environment is not UTF-8."""
    for word in sys.argv[1:]:
        if not _is_utf8(word):
            raise UsageFailure(f"the argument {os.fsencode(word)!r} is not UTF-8; give valid UTF-8")
    if not _is_utf8(os.environ.get("GECOS_PASSWORD", "")):
        raise UsageFailure("GECOS_PASSWORD is not UTF-8; give valid UTF-8")


def _is_utf8(word: str) -> bool:
    """Returns False if Python has lone surrogates in `word`, in place of bytes that are no text."""
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True


def _tell(error: Exception) -> None:
    """Prints why a command failed."""
    words = sys.argv[1:]
    options = words[: words.index("--")] if "--" in words else words
    if "--json" in options:
        with contextlib.suppress(OSError):  # standard output may be full
            print_json(failure_json(error))
            return
    if isinstance(error, click.ClickException):
        error.show()
    elif not isinstance(error, click.Abort) or isinstance(error, InterruptedCommand):
        from gecos.cli.report import printable

        print(f"gecos: {printable(str(error))}", file=sys.stderr)
