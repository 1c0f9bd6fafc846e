"""The verb `gecos wait`."""

from __future__ import annotations

import math

import click

from gecos.cli.options import Number, broker_option, json_option, name_argument, print_json

_PATIENCE = 2.0  # s for one attempt to find an object


@click.command()
@name_argument
@click.option("--timeout", type=Number(), help="Seconds to wait; the default is no limit.")
@broker_option
@json_option
def wait(name: str, timeout: float | None, broker: str | None, as_json: bool) -> None:
    """Waits until an object is online. Ends at once if the object refuses this program, or if no
    medium reaches it from here."""
    import gecos
    from gecos.dynamic_client.connect import find

    longest = math.inf if timeout is None else timeout
    with gecos.Lab(broker) as lab:
        found = find(lab, name, patience=min(_PATIENCE, longest), wait=longest)
    if as_json:
        print_json({"name": name, "type": found._gecos_interface.name})
    else:
        print(f"{name}: online")
