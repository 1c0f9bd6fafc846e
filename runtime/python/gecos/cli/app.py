"""The verbs of `gecos` that concern whole objects, and the start of the command line.

Imports take most of the time of a short command. Therefore each verb imports the modules that only
this verb needs at the start of its function. A verb in a module of its own is imported when it is
used.
"""

from __future__ import annotations

import contextlib
import json
import math
import sys
import threading
import time
from importlib import import_module
from typing import TYPE_CHECKING

import click

from gecos.cli.exit_codes import ExitCode, exit_code, failure_json
from gecos.cli.options import (
    Number,
    broker_option,
    interfaces,
    json_option,
    name_argument,
    names_argument,
    plain,
    print_json,
    silent_names,
)

if TYPE_CHECKING:
    from gecos.lab import Lab
    from gecos.object_watch import ObjectWatch

_STOP_WITHIN = 5.0  # s for the answer of a server
_PATIENCE = 2.0  # s for one attempt to find an object
_ASK_ANYWAY = 1.0  # s after which a server that did not answer is tried again


_VERBS = {
    "call": "members.call",
    "doctor": "doctor.verb.doctor",
    "get": "members.get",
    "hz": "members.hz",
    "keys": "keys.keys",
    "set": "members.set_",
    "up": "up.up",
    "watch": "members.watch",
}
"""Maps each verb that has a module of its own to the module and the name of the function."""


class Verbs(click.Group):
    """The verbs of this module, and those of `_VERBS`, which are imported when they are used."""

    def list_commands(self, context: click.Context) -> list[str]:
        return sorted({*super().list_commands(context), *_VERBS})

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in _VERBS:
            return super().get_command(context, name)
        module, _, function = _VERBS[name].rpartition(".")
        verb: click.Command = getattr(import_module(f"gecos.cli.{module}"), function)
        return verb


def _print_version(context: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        print(f"gecos {_version()}")
        context.exit()


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("robcl")
    except PackageNotFoundError:
        return "of a source tree, which is not installed"


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


@app.command("ls")
@click.option(
    "--interface",
    metavar="NAME",
    default="",
    help="Only objects that have this interface or a derived one, e.g. robcl::Manipulator.",
    shell_complete=interfaces,
)
@click.option("--watch", "watching", is_flag=True, help="Print each change until Ctrl-C.")
@broker_option
@json_option
def list_objects(interface: str, watching: bool, broker: str | None, as_json: bool) -> None:
    """Lists the objects that are online, and those whose servers are silent."""
    import gecos
    from gecos.cli.presence import changes, presences

    with gecos.Lab(broker) as lab:
        if watching:
            for change in changes(lab, interface):
                if as_json:
                    print_json(change)
                else:
                    from gecos.cli import report

                    report.change(change)
            return
        found = presences(lab, interface)
    if as_json:
        states = [{"silent_since": one.silent_since, "answers": one.answers} for one in found]
        print_json([plain(one.entry) | state for one, state in zip(found, states, strict=True)])
    else:
        from gecos.cli import report

        report.objects(found)


@app.command()
@click.argument("name", shell_complete=silent_names)
@broker_option
@json_option
def free(name: str, broker: str | None, as_json: bool) -> None:
    """Gives the name of a silent object free, before the broker does.

    Another server may then take the name. Make sure first that the silent server moves nothing: it
    may be cut off, and still running.
    """
    import gecos

    with gecos.Lab(broker) as lab:
        _set_free(lab, name)
    if as_json:
        print_json({"freed": name})
    else:
        print(f"{name}: free")


def _set_free(lab: Lab, name: str) -> None:
    """Raises CommandFailed if the server of the object is heard or lives, and CreateError if the
    broker does not know the object."""
    from gecos_idl.broker import Broker
    from gecos_idl.broker_types import NameInUse, UnknownName

    from gecos.errors import Attempt, CommandFailed, CreateError, Detail

    try:
        lab.broker(Broker).free(name).result()
    except NameInUse as kept:
        text = f"the name {name} is not set free: {kept.why}"
        raise CommandFailed(Detail.REJECTED, text) from None
    except UnknownName:
        reason = "the broker has no silent object of this name; `gecos ls` shows the silent objects"
        raise CreateError([Attempt(name, Detail.NO_SERVER, reason)]) from None


@app.command()
@name_argument
@broker_option
@json_option
def describe(name: str, broker: str | None, as_json: bool) -> None:
    """Shows the type and state of an object, and its operations, attributes and streams."""
    import gecos
    from gecos.dynamic_client import read_model
    from gecos.dynamic_client.connect import find, served_models

    with gecos.Lab(broker) as lab:
        found = find(lab, name)
        state = gecos.describe(found).result()
        models = served_models(found)
    model = read_model(models, state.interface_name) if models else None
    if as_json:
        print_json(plain(state) | {"models": [json.loads(text) for text in models]})
        return
    from gecos.cli import report

    report.description(state)
    if model is not None:
        report.members(model)


@app.command()
@name_argument
@broker_option
@json_option
def holders(name: str, broker: str | None, as_json: bool) -> None:
    """Shows the clients that hold actor or master status of an object."""
    import gecos
    from gecos.dynamic_client.connect import find

    with gecos.Lab(broker) as lab:
        found = gecos.holders(find(lab, name)).result()
    if as_json:
        print_json([plain(holder) for holder in found])
    else:
        from gecos.cli import report

        report.holders(name, found)


@app.command()
@names_argument
@click.option("--all", "everything", is_flag=True, help="Stop every object that is online.")
@broker_option
@json_option
def stop(names: tuple[str, ...], everything: bool, broker: str | None, as_json: bool) -> None:
    """Stops objects for all clients: ends all leases, drops the queues, interrupts handlers."""
    from concurrent.futures import ThreadPoolExecutor

    import gecos
    from gecos.dynamic_client.connect import entries, find, silent_objects

    if bool(names) == everything:
        raise click.UsageError("give either the names of the objects to stop, or --all")
    with gecos.Lab(broker) as lab:
        wanted = list(names)
        if everything:
            wanted = [entry.name for entry in entries(lab)]
            # Silent objects cannot be stopped, but the user must know of them.
            wanted += [one.entry.name for one in silent_objects(lab)]

        def failure_of(name: str) -> Exception | None:
            try:
                gecos.stop(find(lab, name)).result(_STOP_WITHIN)
            except (ConnectionError, RuntimeError, TimeoutError) as error:
                return error
            return None

        # All objects are stopped at the same time, because an object that does not answer must not
        # keep the others moving.
        wanted = list(dict.fromkeys(wanted))
        with ThreadPoolExecutor(max(1, len(wanted))) as threads:
            outcomes = dict(zip(wanted, threads.map(failure_of, wanted), strict=True))
    failures = [error for error in outcomes.values() if error is not None]
    stopped = [name for name, error in outcomes.items() if error is None]
    if as_json:
        print_json({"stopped": stopped, "failed": [failure_json(e)["error"] for e in failures]})
    else:
        print("\n".join(f"{name}: stopped" for name in stopped) or "nothing was stopped")
    for failure in failures:
        print(f"gecos: {failure}", file=sys.stderr)
    if failures:
        sys.exit(max(map(exit_code, failures)))


@app.command()
@name_argument
@click.option("--timeout", type=Number(), help="Seconds to wait; the default is no limit.")
@broker_option
@json_option
def wait(name: str, timeout: float | None, broker: str | None, as_json: bool) -> None:
    """Waits until an object is online. Ends at once if the object refuses this program."""
    import gecos
    from gecos.dynamic_client.connect import find

    end = math.inf if timeout is None else time.monotonic() + timeout
    with gecos.Lab(broker) as lab, lab.watch() as changes:
        while True:
            left = max(0.0, end - time.monotonic())
            try:
                found = find(lab, name, patience=min(_PATIENCE, left))
                break
            except (gecos.CreateError, gecos.ConnectionFailed) as error:
                if exit_code(error) is ExitCode.NO_ACCESS or time.monotonic() >= end:
                    raise
            _await_change(changes, name, min(end, time.monotonic() + _ASK_ANYWAY))
    if as_json:
        print_json({"name": name, "type": found._gecos_interface.name})
    else:
        print(f"{name}: online")


def _await_change(changes: ObjectWatch, name: str, until: float) -> None:
    """Waits until the broker reports a change of the object called `name`."""
    with contextlib.suppress(TimeoutError):
        while changes.next(max(0.0, until - time.monotonic())).entry.name != name:
            pass


@app.command()
def schema() -> None:
    """Prints the JSON Schema of the output of `--json`, with a definition for each verb."""
    from pathlib import Path

    print((Path(__file__).parent / "output.schema.json").read_text(encoding="utf-8"), end="")


@app.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Prints the completion of `gecos` for a shell. For bash, use: eval "$(gecos completion
    bash)"."""
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    print(kind(app, {}, "gecos", "_GECOS_COMPLETE").source())


@app.command("broker")
@click.option(
    "--name-hold",
    type=Number(),
    default=10.0,
    show_default=True,
    help="Seconds for which a silent server of another host keeps its names.",
)
def run_broker(name_hold: float) -> None:
    """Runs this host's broker until Ctrl-C."""
    import gecos
    from gecos import _core
    from gecos.termination_signals import TerminationSignals

    with (
        TerminationSignals() as signals,
        gecos.Lab() as lab,
        gecos.Broker(lab, name_hold=name_hold),
    ):
        print("broker: ready", flush=True)
        others = threading.Thread(target=_core.warn_of_other_brokers)
        others.start()
        signals.wait()
        others.join()


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
    elif not isinstance(error, click.Abort):
        from gecos.cli.report import printable

        print(f"gecos: {printable(str(error))}", file=sys.stderr)
