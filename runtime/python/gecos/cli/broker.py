"""The verb `gecos broker`: the broker of this host."""

from __future__ import annotations

import threading

import click

from gecos.cli.options import Number, json_option, print_json


@click.command()
@click.option(
    "--name-hold",
    type=Number(),
    default=10.0,
    show_default=True,
    help="Seconds for which a silent server of another host keeps its names.",
)
@json_option
def broker(name_hold: float, as_json: bool) -> None:
    """Runs this host's broker until Ctrl-C."""
    import gecos
    from gecos import _core
    from gecos.termination_signals import TerminationSignals

    with (
        TerminationSignals() as signals,
        gecos.Lab() as lab,
        gecos.Broker(lab, name_hold=name_hold),
    ):
        if as_json:
            print_json({"event": "ready", "text": "broker: ready"})
        else:
            print("broker: ready", flush=True)
        others = threading.Thread(target=_core.warn_of_other_brokers)
        others.start()
        signals.wait()
        others.join()
