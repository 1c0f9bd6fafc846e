"""The verb `gecos holders`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from gecos.cli.options import broker_option, json_option, name_argument, plain, print_json

if TYPE_CHECKING:
    from gecos_idl.object_types import Roster

    import gecos


# The most changes that may have been missed. A larger difference between two change numbers means
# that another server serves the object: each server counts from a random number of 52 bits.
MOST_MISSED = 2**32


@click.command()
@name_argument
@click.option(
    "--watch", "watching", is_flag=True, help="Print the holders at each change until Ctrl-C."
)
@broker_option
@json_option
def holders(name: str, watching: bool, broker: str | None, as_json: bool) -> None:
    """Shows the clients that hold actor or master status of an object."""
    import gecos
    from gecos.cli import report
    from gecos.dynamic_client.connect import find

    with gecos.Lab(broker) as lab:
        robot = find(lab, name)
        if watching:
            for told in rosters(robot):
                _print(name, told, as_json)
        elif as_json:
            print_json([plain(holder) for holder in gecos.holders(robot).result()])
        else:
            report.holders(name, gecos.holders(robot).result())


def _print(name: str, told: Roster, as_json: bool) -> None:
    from gecos.cli import report

    if as_json:
        print_json([plain(holder) for holder in told.holders])
        return
    for change in told.changes:
        report.roster_change(change)
    report.holders(name, told.holders)
    print(flush=True)


def rosters(robot: gecos.Object, timeout: float | None = None) -> Iterator[Roster]:
    """Yields the present roster without past changes. Then, at each change, yields the roster
    together with the changes since the previous roster. Warns on stderr when changes were missed,
    or when another server serves the object now. Raises TimeoutError if no change comes within
    `timeout` s."""
    import gecos

    name = robot._gecos_session.object_name
    told = gecos.roster(robot).result()
    told.changes = []
    while True:
        yield told
        known = told.newest
        told = gecos.roster(robot, known, timeout).result()
        if told.newest == known:
            raise TimeoutError(f"{name}: its holders have not changed within {timeout} s")
        if missing := _missing(told, known):
            click.echo(f"gecos: {name}: {missing}", err=True)


def _missing(told: Roster, known: int) -> str:
    """Returns a text about the changes that were missed between the change with the number `known`
    and the changes of `told`. Returns an empty text if no change was missed."""
    missed = told.newest - known - len(told.changes)
    if missed == 0:
        return ""
    if 0 < missed < MOST_MISSED:
        return f"{missed} earlier changes of the holders of this object were missed"
    return (
        "another server serves this object now; earlier changes of its holders may have been missed"
    )
