"""Options and arguments that several verbs have, and the output of JSON."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from typing import Any

import click
from click.shell_completion import CompletionItem

_MOST = 1e6  # s
_MOMENT = 0.5  # s for which a completion waits for a broker and for a server


def _names(context: click.Context, _: click.Parameter, begun: str) -> list[CompletionItem]:
    """Returns the objects that are online, for the completion of a shell; none if there is no
    broker."""
    import gecos
    from gecos.dynamic_client.connect import entries

    try:
        with gecos.Lab(context.params.get("broker")) as lab:
            known = entries(lab, patience=_MOMENT)
    except (ConnectionError, RuntimeError):
        return []
    return [
        CompletionItem(entry.name, help=entry.interface_name)
        for entry in known
        if entry.name.startswith(begun)
    ]


def silent_names(context: click.Context, _: click.Parameter, begun: str) -> list[CompletionItem]:
    """Returns the objects whose servers are silent, for the completion of a shell."""
    import gecos
    from gecos.dynamic_client.connect import silent_objects

    try:
        with gecos.Lab(context.params.get("broker")) as lab:
            known = [one.entry for one in silent_objects(lab, patience=_MOMENT)]
    except (ConnectionError, RuntimeError):
        return []
    return [
        CompletionItem(entry.name, help=entry.interface_name)
        for entry in known
        if entry.name.startswith(begun)
    ]


def interfaces(context: click.Context, _: click.Parameter, begun: str) -> list[CompletionItem]:
    """Returns the interfaces of the objects that are online, for the completion of a shell."""
    import gecos

    try:
        with gecos.Lab(context.params.get("broker")) as lab:
            known = lab.objects(patience=_MOMENT)
    except (ConnectionError, RuntimeError):
        return []
    names = {name for entry in known for name in (entry.interface_name, *entry.bases)}
    return [CompletionItem(name) for name in sorted(names) if name.startswith(begun)]


def members(
    wanted: Callable[[Any], bool],
) -> Callable[[click.Context, click.Parameter, str], list[CompletionItem]]:
    """Returns the completion for members of the object that the command line names before. Only
    members for which `wanted` is true are offered."""

    def complete(context: click.Context, _: click.Parameter, begun: str) -> list[CompletionItem]:
        import gecos
        from gecos.dynamic_client.connect import connect

        try:
            with gecos.Lab(context.params.get("broker")) as lab:
                model = connect(lab, context.params["name"], patience=_MOMENT)._gecos_model
        except (ConnectionError, RuntimeError, ValueError):
            return []
        found = {m.name: m.doc.partition("\n")[0] for m in model.members if wanted(m)}
        return [
            CompletionItem(name, help=doc) for name, doc in found.items() if name.startswith(begun)
        ]

    return complete


name_argument = click.argument("name", shell_complete=_names)
names_argument = click.argument("names", metavar="NAME...", nargs=-1, shell_complete=_names)
broker_option = click.option(
    "--broker",
    metavar="ADDRESS",
    help="Address of the broker; default: GECOS_BROKER, else this host.",
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print JSON; `gecos schema` describes it."
)


def print_json(value: Any) -> None:
    """Prints a value as one line of JSON. Characters that the output cannot encode are escaped."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding)
    except UnicodeEncodeError:
        text = json.dumps(value, allow_nan=False)
    print(text, flush=True)


def plain(value: Any) -> Any:
    """Returns a generated value as data for JSON."""
    from gecos.wire.kinds import kind_of

    return kind_of(type(value)).plain(value)


def value_of(text: str) -> Any:
    """Returns a value from the command line: JSON, or else the text itself as the name of an
    enumerator. Raises JsonError for JSON with two entries of the same name, and for numbers that
    are too large."""
    from gecos.wire import json as gecos_json

    try:
        return gecos_json.plain(text)
    except gecos_json.NotJsonError:
        return text


class Number(click.ParamType):
    """A finite number that is at least `least`."""

    name = "number"

    def __init__(self, least: float = 0.0) -> None:
        self.least = least

    def convert(
        self, value: Any, param: click.Parameter | None, context: click.Context | None
    ) -> float:
        try:
            number = float(value)
        except ValueError:
            self.fail(f"{value!r} is not a number", param, context)
        if not (math.isfinite(number) and self.least <= number <= _MOST):
            self.fail(f"{value} is not from {self.least:g} to {_MOST:g}", param, context)
        return number
