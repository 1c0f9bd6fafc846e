"""Prints the output of the commands of `gecos` as tables, on a terminal and into a pipe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry
    from gecos_idl.object_types import Description, Holder, RunningHandler


def objects(entries: Sequence[Entry]) -> None:
    if not entries:
        print("no object is online")
        return
    rows = [
        (
            entry.name,
            entry.interface_name,
            f"{entry.user}@{entry.hostname}",
            str(entry.pid),
            _media(entry),
            "simulated" if entry.simulated else "hardware",
        )
        for entry in entries
    ]
    _table(("name", "type", "served by", "pid", "media", ""), rows)


def _media(entry: Entry) -> str:
    """The media by which other programs reach the object."""
    kinds = {address.partition(":")[0] for address in entry.addresses} - {"inproc"}
    return ", ".join(sorted(kinds)) or "the server's process only"


def description(of: Description) -> None:
    facts = (
        ("type", f"{of.interface_name} {of.version}".strip()),
        ("device", "simulated" if of.simulated else "hardware"),
        ("presence", of.presence),
        ("authentication", of.authentication),
        ("executing", of.executing or "nothing"),
        ("queued", str(of.queued)),
        ("epoch", f"{of.epoch:#x}"),
        ("pid", str(of.pid)),
        ("name", of.registration),
    )
    print(of.name)
    for name, value in facts:
        print(f"  {name:<16}{value}")
    for handler in of.handlers:
        print(f"  {'handler':<16}{_running(handler)}")


def _running(handler: RunningHandler) -> str:
    waits = f", waits for {handler.waits_for}" if handler.waits_for else ""
    return (
        f"{handler.operation} for {handler.running_for:.1f} s, called by {handler.user} on "
        f"{handler.host} ({handler.program}, pid {handler.pid}){waits}"
    )


def holders(name: str, who: Sequence[Holder]) -> None:
    if not who:
        print(f"{name}: nobody holds actor or master status")
        return
    rows = [
        (
            holder.status.name.lower(),
            f"{holder.user}@{holder.host}",
            holder.program,
            str(holder.pid),
            f"{holder.held_for:.1f} s",
            "releasing" if holder.releasing else f"{holder.expires_in:.1f} s",
        )
        for holder in who
    ]
    _table(("status", "client", "program", "pid", "held for", "ends if silent"), rows)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(*heads, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row)
    console = Console()
    if not console.is_terminal:
        console.width = 10_000  # do not break lines in a pipe
    console.print(table)
