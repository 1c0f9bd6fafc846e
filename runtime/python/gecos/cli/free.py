"""The verb `gecos free`."""

from __future__ import annotations

import click

from gecos.cli.options import broker_option, json_option, print_json, silent_names


@click.command()
@click.argument("name", shell_complete=silent_names)
@broker_option
@json_option
def free(name: str, broker: str | None, as_json: bool) -> None:
    """Gives the name of a silent object free, before the broker does.

    Another server may then take the name. Make sure first that the silent server moves nothing: it
    may be cut off, and still running.
    """
    from gecos_idl.broker import Broker

    import gecos

    with gecos.Lab(broker) as lab:
        lab.broker(Broker).free(name).result()
    if as_json:
        print_json({"freed": name})
    else:
        print(f"{name}: free")
