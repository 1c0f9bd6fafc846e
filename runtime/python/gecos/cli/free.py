"""The verb `gecos free`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gecos.cli.options import broker_option, json_option, print_json, silent_names

if TYPE_CHECKING:
    from gecos.lab import Lab


@click.command()
@click.argument("name", shell_complete=silent_names)
@broker_option
@json_option
def free(name: str, broker: str | None, as_json: bool) -> None:
    """Frees the name of a silent object before the broker does.

    Another server may then take the name. Make sure first that the silent server moves nothing,
    because a server that is only disconnected may still run.
    """
    import gecos

    with gecos.Lab(broker) as lab:
        _set_free(lab, name)
    if as_json:
        print_json({"freed": name})
    else:
        print(f"{name}: free")


def _set_free(lab: Lab, name: str) -> None:
    """Raises CommandFailed if the broker still hears the server of the object, or if the process of
    that server still runs. Raises CreateError if the broker does not know the object."""
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
