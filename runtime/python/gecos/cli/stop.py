"""The verb `gecos stop`."""

from __future__ import annotations

import sys

import click

from gecos.cli.exit_codes import exit_code, failure_json
from gecos.cli.options import broker_option, json_option, names_argument, print_json


@click.command()
@names_argument
@click.option("--all", "everything", is_flag=True, help="Stop every object that is online.")
@broker_option
@json_option
def stop(names: tuple[str, ...], everything: bool, broker: str | None, as_json: bool) -> None:
    """Stops objects for all clients: ends all leases, drops the queues, interrupts handlers."""
    import gecos
    from gecos.cli.report import printable
    from gecos.cli.stopping import stop_objects

    if bool(names) == everything:
        raise click.UsageError("give either the names of the objects to stop, or --all")
    with gecos.Lab(broker) as lab:
        stopping = stop_objects(lab, None if everything else names)
    unknown = stopping.silent_unknown
    failures = {name: error for name, error in stopping.outcomes.items() if error is not None}
    stopped = [name for name in stopping.outcomes if name not in failures]
    if as_json:
        failed = [{"name": n} | failure_json(error)["error"] for n, error in failures.items()]
        more = {} if unknown is None else {"silent_unknown": failure_json(unknown)["error"]}
        print_json({"stopped": stopped, "failed": failed} | more)
    else:
        print("\n".join(f"{name}: stopped" for name in stopped) or "nothing was stopped")
    for name, error in failures.items():
        why = str(error).removeprefix(f"{name}: ")
        print(printable(f"gecos: {name} was not stopped: {why}"), file=sys.stderr)
    if unknown is not None:
        why = f"the broker did not say which other objects are silent: {unknown}"
        print(printable(f"gecos: {why}"), file=sys.stderr)
    errors = [*failures.values(), *([unknown] if unknown else [])]
    if errors:
        sys.exit(max(map(exit_code, errors)))
