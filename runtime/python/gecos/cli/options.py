"""Options and arguments that several verbs have, and the output of JSON."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    import gecos

_MOST = 1e6  # largest number that an option accepts by default, in most options seconds
_MOMENT = 0.5  # s; longest wait of a completion for the answer of a broker or of a server


Completion = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def _completion(words: Callable[[gecos.Lab, Mapping[str, Any]], Mapping[str, str]]) -> Completion:
    """Returns a completion for a shell. `words` gets the preceding words of the command line, and
    returns each possible next word together with its help text. Without a broker there are no
    words."""

    def complete(context: click.Context, _: click.Parameter, begun: str) -> list[CompletionItem]:
        import gecos

        try:
            with gecos.Lab(context.params.get("broker")) as lab:
                found = words(lab, context.params)
        except (ConnectionError, RuntimeError, ValueError):
            return []
        return [
            CompletionItem(word, help=help or None)
            for word, help in found.items()
            if word.startswith(begun)
        ]

    return complete


@_completion
def _names(lab: gecos.Lab, _: Mapping[str, Any]) -> Mapping[str, str]:
    """Completes the names of objects that are online."""
    from gecos.dynamic_client.connect import entries

    return {entry.name: entry.interface_name for entry in entries(lab, patience=_MOMENT)}


@_completion
def silent_names(lab: gecos.Lab, _: Mapping[str, Any]) -> Mapping[str, str]:
    """Returns, for shell completion, the names of objects whose servers are silent."""
    from gecos.dynamic_client.connect import silent_objects

    silent = silent_objects(lab, patience=_MOMENT)
    return {one.entry.name: one.entry.interface_name for one in silent}


@_completion
def interfaces(lab: gecos.Lab, _: Mapping[str, Any]) -> Mapping[str, str]:
    """Completes the interfaces of the objects that are online, and the bases of these
    interfaces."""
    known = lab.objects(patience=_MOMENT)
    names = {name for entry in known for name in (entry.interface_name, *entry.bases)}
    return dict.fromkeys(sorted(names), "")


def members(wanted: Callable[[Any], bool]) -> Completion:
    """Returns the completion for members of the object that precedes them on the command line. Only
    members for which `wanted` is true are offered."""

    def found(lab: gecos.Lab, before: Mapping[str, Any]) -> Mapping[str, str]:
        from gecos.dynamic_client.connect import connect

        model = connect(lab, before["name"], patience=_MOMENT)._gecos_model
        return {m.name: m.doc.partition("\n")[0] for m in model.members if wanted(m)}

    return _completion(found)


name_argument = click.argument("name", shell_complete=_names)
optional_name_argument = click.argument("name", required=False, shell_complete=_names)
names_argument = click.argument("names", metavar="NAME...", nargs=-1, shell_complete=_names)
broker_option = click.option(
    "--broker",
    metavar="ADDRESS",
    help="Address of the broker; default: GECOS_BROKER, else the lab file, else this host.",
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
    """A finite number from `least` to `most`."""

    name = "number"

    def __init__(self, least: float = 0.0, most: float = _MOST) -> None:
        self.least = least
        self.most = most

    def convert(
        self, value: Any, param: click.Parameter | None, context: click.Context | None
    ) -> float:
        try:
            number = float(value)
        except ValueError:
            self.fail(f"{value!r} is not a number", param, context)
        if not (math.isfinite(number) and self.least <= number <= self.most):
            self.fail(f"{value} is not from {self.least:g} to {self.most:g}", param, context)
        return number
