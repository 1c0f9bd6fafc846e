"""The verb `gecos describe`."""

from __future__ import annotations

import json
import time
from enum import Enum
from typing import TYPE_CHECKING, Any

import click

from gecos.cli.options import broker_option, json_option, name_argument, plain, print_json

if TYPE_CHECKING:
    from gecos.dynamic_client import Attribute, Model
    from gecos.lab import Lab

_READ_WITHIN = 0.5  # s in which an object must answer; a value that comes later is left out


@click.command()
@name_argument
@broker_option
@json_option
def describe(name: str, broker: str | None, as_json: bool) -> None:
    """Shows the type and state of an object, and its operations, attributes and streams.

    Shows the value of each readonly attribute that is a number, a boolean, a text or an enumerator,
    has no stream and needs no status.
    """
    import gecos
    from gecos.dynamic_client import read_model
    from gecos.dynamic_client.connect import find, served_models, without_model

    with gecos.Lab(broker) as lab:
        found = find(lab, name)
        state = gecos.describe(found).result()
        models = served_models(found)
        model = read_model(models, state.interface_name) if models else None
        values = {} if model is None else _readings(lab, name, model, models)
    if as_json:
        served = [json.loads(text) for text in models]
        print_json(plain(state) | {"readings": values, "models": served})
        return
    from gecos.cli import report

    report.description(state)
    if model is None:
        print(f"\n{without_model(name)}")
    else:
        report.members(model, values)


def _readings(lab: Lab, name: str, model: Model, models: list[str]) -> dict[str, Any]:
    """Returns the values of the attributes that describe an object. Leaves out each attribute whose
    value does not arrive in time, for example because the object is busy with another call."""
    from gecos.dynamic_client import Attribute, by_name
    from gecos.dynamic_client.proxy import proxy_class
    from gecos.errors import CommandFailed, ConnectionFailed, CreateError

    shown = [
        each.name for each in model.members if isinstance(each, Attribute) and _tells(each, model)
    ]
    if not shown:
        return {}
    try:
        robot = lab.create(proxy_class(models, model.interface, shown), name)
    except CreateError:
        return {}
    until = time.monotonic() + _READ_WITHIN
    values: dict[str, Any] = {}
    for attribute, command in [(each, by_name.read(robot, each)) for each in shown]:
        try:
            value = command.result(max(0.0, until - time.monotonic()))
        except (TimeoutError, CommandFailed, ConnectionFailed):
            continue
        values[attribute] = value.name if isinstance(value, Enum) else value
    return values


def _tells(attribute: Attribute, model: Model) -> bool:
    """Returns whether an attribute is a single value that any client may read and nobody sets."""
    from gecos.dynamic_client.model import Enumeration

    use, _ = model.resolved(attribute.result.use)
    single = use.kind in {"primitive", "string"}
    return (
        attribute.can_be_read
        and attribute.readonly
        and attribute.stream is None
        and attribute.access == 0
        and (single or isinstance(model.types.get(use.name), Enumeration))
        and not attribute.result.secret
    )
