"""The verb `gecos holders`."""

from __future__ import annotations

import click

from gecos.cli.options import broker_option, json_option, name_argument, plain, print_json


@click.command()
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
