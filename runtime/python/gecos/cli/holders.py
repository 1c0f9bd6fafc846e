"""The verb `gecos holders`."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from gecos.cli.options import broker_option, json_option, name_argument, plain, print_json

if TYPE_CHECKING:
    from gecos_idl.object_types import Holder

    import gecos

_BETWEEN_LOOKS = 0.2  # s


@click.command()
@name_argument
@click.option("--watch", "watching", is_flag=True, help="Print them at each change until Ctrl-C.")
@broker_option
@json_option
def holders(name: str, watching: bool, broker: str | None, as_json: bool) -> None:
    """Shows the clients that hold actor or master status of an object."""
    import gecos
    from gecos.dynamic_client.connect import find

    with gecos.Lab(broker) as lab:
        robot = find(lab, name)
        for found in _changes(robot) if watching else [gecos.holders(robot).result()]:
            if as_json:
                print_json([plain(holder) for holder in found])
            else:
                _print(name, found, watching)


def _print(name: str, found: list[Holder], watching: bool) -> None:
    from gecos.cli import report

    if watching:
        print(f"\n{time.strftime('%H:%M:%S')}")
    report.holders(name, found)
    print(end="", flush=True)


def _changes(robot: gecos.Object) -> Iterator[list[Holder]]:
    """Yields the present holders, and again each time that a holder came, left, released, took over
    or gave back. Changes that last less than `_BETWEEN_LOOKS` may be missed."""
    import gecos

    before = None
    while True:
        found = gecos.holders(robot).result()
        now = [
            (each.status, each.user, each.host, each.pid, each.releasing, each.taken_over)
            for each in found
        ]
        if now != before:
            yield found
        before = now
        time.sleep(_BETWEEN_LOOKS)
