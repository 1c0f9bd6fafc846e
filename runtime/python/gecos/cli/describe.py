"""The verb `gecos describe`."""

from __future__ import annotations

import json

import click

from gecos.cli.options import broker_option, json_option, name_argument, plain, print_json


@click.command()
@name_argument
@broker_option
@json_option
def describe(name: str, broker: str | None, as_json: bool) -> None:
    """Shows the type and state of an object, and its operations, attributes and streams."""
    import gecos
    from gecos.dynamic_client import read_model
    from gecos.dynamic_client.connect import find, served_models, without_model

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
    if model is None:
        print(f"\n{without_model(name)}")
    else:
        report.members(model)
