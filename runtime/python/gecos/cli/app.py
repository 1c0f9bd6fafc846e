"""The start of the command line, and what it prints when a verb fails.

Imports take most of the time of a short command. Therefore the module of a verb is imported only
when the verb is used, and the function of the verb imports the modules that only this verb needs.
"""

from __future__ import annotations

import contextlib
import sys
from importlib import import_module

import click

from gecos.cli.exit_codes import ExitCode, InterruptedCommand, exit_code, failure_json
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
    try:
        code = app(prog_name="gecos", standalone_mode=False)
    except click.exceptions.Exit as end:
        return end.exit_code
    except SystemExit as end:
        return int(end.code or 0)
    except (click.ClickException, click.Abort, OSError, RuntimeError, ValueError) as error:
        _tell(error)
        return exit_code(error)
    return code if isinstance(code, int) else ExitCode.FINISHED


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
