"""Options and arguments that several verbs have, and JSON output."""

from __future__ import annotations

import json
from typing import Any

import click

name_argument = click.argument("name")
broker_option = click.option(
    "--broker",
    metavar="ADDRESS",
    help="Address of the broker; default: GECOS_BROKER, else this host.",
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print JSON: see `gecos schema`."
)


def print_json(value: Any) -> None:
    print(json.dumps(value, ensure_ascii=False, allow_nan=False), flush=True)


def plain(value: Any) -> Any:
    """A generated value as data for JSON."""
    from gecos.wire.kinds import kind_of

    return kind_of(type(value)).plain(value)


def value_of(text: str) -> Any:
    """A value on the command line: JSON, else the text itself, as the name of an enumerator."""
    try:
        return json.loads(text)
    except ValueError:
        return text
