"""The verb `gecos break`."""

from __future__ import annotations

import click

from gecos.cli.options import broker_option, json_option, name_argument, print_json


@click.command("break")
@name_argument
@click.option("--why", required=True, help="The reason, which the holders are told.")
@broker_option
@json_option
def break_status(name: str, why: str, broker: str | None, as_json: bool) -> None:
    """Takes actor or master status away from all clients that hold it.

    Their commands end as LEASE_LOST, with your name and the reason. You must be an administrator:
    the user of the server, root, or a user in [admin] of its lab file. Ask the holders first;
    `gecos holders` lists them.
    """
    from gecos_idl.object_types import StatusRefused

    import gecos
    from gecos.dynamic_client.connect import find

    with gecos.Lab(broker) as lab:
        robot = find(lab, name)
        held = bool(gecos.holders(robot).result())
        try:
            gecos.break_status(robot, why).result()
        except StatusRefused as refused:
            raise gecos.CommandFailed(gecos.Detail.DENIED, refused.reason) from None
    if as_json:
        print_json({"broken": name, "was_held": held})
    else:
        print(f"{name}: nobody {'holds its status any more' if held else 'held its status before'}")
