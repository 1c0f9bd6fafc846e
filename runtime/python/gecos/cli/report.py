"""Prints the output of the commands of `gecos` for people, on a terminal or into a pipe."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from shutil import get_terminal_size
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from gecos.cli.options import print_json

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry
    from gecos_idl.object_types import Description, Holder, RosterChange, RunningHandler

    from gecos.cli.presence import Presence
    from gecos.dynamic_client import Attribute, Member, Model, Operation, Value
    from gecos.dynamic_client.model import Declaration
    from gecos.interface import Quality
    from gecos.stream import Sample


def objects(found: Sequence[Presence]) -> None:
    if not found:
        print("no object is online")
        return
    rows = [
        (
            one.entry.name,
            one.entry.interface_name,
            f"{one.entry.user}@{one.entry.hostname}",
            str(one.entry.pid),
            _media(one.entry),
            _state(one),
        )
        for one in found
    ]
    table(("name", "type", "served by", "pid", "media", ""), rows)


def change(of: dict[str, Any]) -> None:
    """Prints one line of `gecos ls --watch`."""
    from gecos.dynamic_client.silence import told

    if of["skipped"]:
        print(f"{of['skipped']} changes were read too late; the state after them follows")
    since = of["silent_since"]
    presence = of["presence"].lower() if since is None else told(since)
    who = f"{of['interface_name']}, {of['user']}@{of['hostname']} pid {of['pid']}"
    print(printable(f"{of['name']}: {presence} ({who})"), flush=True)


def _state(of: Presence) -> str:
    device = "simulated" if of.entry.simulated else "hardware"
    return device if of.problem is None else f"{device}, {of.problem}"


def _media(entry: Entry) -> str:
    """Returns the media by which other programs reach the object."""
    kinds = {address.partition(":")[0] for address in entry.addresses} - {"inproc"}
    return ", ".join(sorted(kinds)) or "only the server's own process"


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
    print(printable(of.name))
    for name, value in facts:
        print(f"  {name:<16}{printable(value)}")
    for handler in of.handlers:
        print(f"  {'handler':<16}{printable(_running(handler))}")


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
    held_off = "held off" if any(holder.taken_over for holder in who) else "none"
    rows = [
        (
            holder.status.name.lower(),
            f"{holder.user}@{holder.host}",
            holder.program,
            str(holder.pid),
            f"{holder.held_for:.1f} s",
            "releasing" if holder.releasing else f"{holder.expires_in:.1f} s",
            f"took over {holder.taken_over_for:.1f} s ago" if holder.taken_over else held_off,
        )
        for holder in who
    ]
    heads = ("status", "client", "program", "pid", "held for", "ends if silent", "take-over")
    table(heads, rows)


def roster_change(of: RosterChange) -> None:
    """Prints one line: when the holders of an object changed, and how."""
    at = datetime.fromtimestamp(time.time() - of.ago).strftime("%H:%M:%S")
    print(printable(f"{at} {_changed(of)}"), flush=True)


def _changed(of: RosterChange) -> str:
    holder = of.holder
    who = f"{holder.user}@{holder.host} ({holder.program}, pid {holder.pid})"
    status = f"{holder.status.name.lower()} status"
    match of.what.name:
        case "ACQUIRED":
            return f"{who} has {status}"
        case "RELEASING":
            return f"{who} has released {status}; its last commands still run"
        case "TAKEN_OVER":
            return f"{who} has taken over"
        case "GIVEN_BACK":
            return f"{who} has given back"
    return f"{status} of {who} ended after {holder.held_for:.1f} s: {of.why}"


def members(model: Model, values: Mapping[str, Any]) -> None:
    """Prints the attributes, operations and types of an interface, with units, ranges and access.
    `values` has the known values of attributes."""

    from gecos.dynamic_client import Attribute

    shown = list(dict.fromkeys(model.members))
    attributes = [each for each in shown if isinstance(each, Attribute) and not each.event]
    events = [each for each in shown if isinstance(each, Attribute) and each.event]
    operations = [each for each in shown if not isinstance(each, Attribute)]
    if attributes:
        print("\nattributes")
    for attribute in attributes:
        known = f" = {_text(values[attribute.name])}" if attribute.name in values else ""
        line = f"{attribute.name}: {_typed(attribute.result)}{known}{_how_read(attribute)}"
        print(f"  {printable(line)}")
        _doc(attribute)
    if events:
        print("\nevents")
    for event in events:
        line = f"{event.name}({', '.join(_arguments(model, event))}){_how_watched(event)}"
        print(f"  {printable(line)}")
        _doc(event)
    if operations:
        print("\noperations")
    for operation in operations:
        inputs = ", ".join(f"{p.name}: {_typed(p)}{_default(p)}" for p in operation.inputs)
        outputs = ", ".join(_typed(p) for p in operation.outputs)
        gives = f" -> {outputs}" if outputs else ""
        print(f"  {printable(f'{operation.name}({inputs}){gives}{_how_called(operation)}')}")
        _doc(operation)

    _types(model)


def _arguments(model: Model, event: Attribute) -> Iterator[str]:
    declared = model.types.get(event.result.use.name)
    return iter(()) if declared is None else _parts(model, declared)


def _how_watched(event: Attribute) -> str:
    words = [] if event.access == 0 else [f"watch: {event.access.name.lower()}"]
    words += _demanded(event.quality)
    return f"  ({', '.join(words)})" if words else ""


def _types(model: Model) -> None:
    """Prints the members, enumerators, flags and arms of the types that the interface uses. The
    structs of events are left out, because their members are printed with the events."""
    of_events = {m.result.use.name for m in model.members if m.kind == "event" and m.result}
    shown = [
        (name, list(_parts(model, declared)))
        for name, declared in model.types.items()
        if name not in of_events
    ]
    if shown:
        print("\ntypes")
    for name, parts in shown:
        print(f"  {printable(name)}: {printable(', '.join(parts))}")


def _parts(model: Model, declared: Declaration) -> Iterator[str]:
    from gecos.dynamic_client.model import Bitmask, Bitset, Enumeration, Struct, Typedef, Union

    match declared:
        case Struct():
            for member in model.all_members(declared):
                yield f"{member.name}: {_typed(member)}{_default(member)}"
        case Enumeration(enumerators=named) | Bitmask(flags=named):
            yield from (name for name, _ in named)
        case Bitset():
            for name, _, width, _ in model.all_fields(declared):
                yield f"{name}: {width} bits"
        case Union(cases=cases):
            for case in cases:
                yield f"{case.member.name}: {_typed(case.member)}"
        case Typedef(use=use, limits=limits):
            yield str(use) + ("" if limits is None else f" [{limits}]")


def _doc(member: Member) -> None:
    for line in member.doc.splitlines():
        print(f"      {printable(line.strip())}")


def _typed(value: Value) -> str:
    """Returns the type of a value with its unit and range, for example "double [m, 0.01 to
    1.0]"."""
    notes = [note for note in (value.unit, value.range) if note]
    return value.type + (f" [{', '.join(notes)}]" if notes else "")


def _default(value: Value) -> str:
    if value.optional:
        return "?"
    if value.default is None:
        return ""
    return f" = {_json(value.default)}"


def _demanded(quality: Quality) -> list[str]:
    """Returns what `@qos` demands, for example ["class SOFT_REALTIME", "deadline 0.5 s"]."""
    words = [] if not quality.line else [f"class {quality.line.name}"]
    if quality.reliability.name == "RELIABLE":
        words.append("reliability RELIABLE")
    for term in ("deadline", "start_by", "latency", "lifespan"):
        if length := getattr(quality, f"{term}_ns"):
            words.append(f"{term} {length * 1e-9:g} s")
    if quality.manual_liveliness:
        words.append("liveliness MANUAL")
    if quality.depth:
        words.append(f"depth {quality.depth}")
    if quality.media:
        words.append(f"media {'|'.join(str(each.name).lower() for each in quality.media)}")
    return words


def _how_read(attribute: Attribute) -> str:
    if attribute.inward and attribute.stream is not None:
        rate = f" at {attribute.stream.rate_hz:g} Hz" if attribute.stream.rate_hz else ""
        watched = attribute.stream.watchdog_ns
        watchdog = f", watchdog {watched * 1e-6:g} ms" if watched else ""
        sent = f"stream in{rate}{watchdog}, send: {attribute.write_access.name.lower()}"
        return f"  ({', '.join([sent, *_demanded(attribute.quality)])})"
    words = [] if attribute.access == 0 else [f"read: {attribute.access.name.lower()}"]
    if attribute.can_be_set:
        words.append(f"set: {attribute.write_access.name.lower()}")
    if attribute.stream is not None:
        rate = f" at {attribute.stream.rate_hz:g} Hz" if attribute.stream.rate_hz else ""
        words.append(f"stream out{rate}{', open to anybody' if attribute.stream.open else ''}")
    words += _demanded(attribute.quality)
    return f"  ({', '.join(words)})" if words else ""


def _how_called(operation: Operation) -> str:
    words = [operation.access.name.lower()]
    flags = ("safety", "cancelable", "idempotent", "parallel", "ordered")
    words += [word for word in flags if getattr(operation, word)]
    if operation.on_new:  # not QUEUE
        words.append(f"on_new {operation.on_new.name.lower()}")
    if operation.on_loss:  # not STOP
        words.append(f"on_loss {operation.on_loss.name.lower()}")
    words += _demanded(operation.quality)
    if operation.feedback:
        words.append(f"feedback {operation.feedback}")
    if operation.raises:
        words.append(f"raises {', '.join(operation.raises)}")
    return f"  ({', '.join(words)})"


def value(of: Any, unit: str) -> None:
    """Prints a result or the value of an attribute. Values with members are printed as indented
    JSON."""
    print(_with_unit(of, unit, indent=2))


def _with_unit(of: Any, unit: str, indent: int | None = None) -> str:
    """Returns the text of a value. A single number or text is followed by its unit."""
    named = unit and unit != "1" and not isinstance(of, dict | list)  # "1": a number without a unit
    shown = f" {printable(unit)}" if named else ""
    return _text(of, indent) + shown


def _text(of: Any, indent: int | None = None) -> str:
    if isinstance(of, str):
        return printable(of)
    return _json(of, indent)


def _json(of: Any, indent: int | None = None) -> str:
    """Returns JSON with escaped control characters, for example \\u009b, because a terminal would
    execute them."""
    return "".join(
        c if c.isprintable() or c == "\n" else json.dumps(c)[1:-1]
        for c in json.dumps(of, indent=indent, ensure_ascii=False)
    )


def printable(text: str) -> str:
    """Returns `text`, which comes from a server, with escaped control characters, because a
    terminal would execute them."""
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text
    )


def rate(line: dict[str, Any]) -> None:
    lost = f", {line['lost']} lost" if line["lost"] else ""
    periods = ""
    if line["min_period"] is not None:
        shortest, longest = line["min_period"] * 1e3, line["max_period"] * 1e3
        periods = f", period {shortest:.2f} to {longest:.2f} ms"
    print(f"{line['rate']:.1f} Hz{periods}{lost}", flush=True)


def event(name: str, sample: Sample[Any]) -> None:
    """Prints an event on a line: when it occurred, its name and its arguments."""
    at = datetime.fromtimestamp(sample.stamp).isoformat(sep=" ", timespec="milliseconds")
    missed = f"  ({sample.lost} missed before)" if sample.lost else ""
    print(f"{at}  {printable(name)}  {_json(sample.value)}{missed}", flush=True)


class Samples:
    """Shows one sample after another. With `replace`, on a terminal, each sample replaces the
    previous one; otherwise each sample is a line. `unit` is the unit of the values."""

    def __init__(self, as_json: bool, unit: str, replace: bool) -> None:
        self._unit = unit
        self._as_json = as_json
        terminal = sys.stdout is not None and sys.stdout.isatty()
        self._in_place = terminal and replace and not as_json
        self._lines = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._in_place:
            print()

    def show(self, sample: dict[str, Any]) -> None:
        if self._as_json:
            print_json(sample)
        elif self._in_place:
            self._redraw(_with_unit(sample["value"], self._unit, indent=2).splitlines())
        else:
            print(_with_unit(sample["value"], self._unit), flush=True)

    def _redraw(self, lines: list[str]) -> None:
        """Replaces the lines of the previous sample. Text that does not fit on the terminal is
        cut."""
        columns, rows = get_terminal_size()
        lines = [line[: columns - 1] for line in lines[: rows - 1]]
        up = f"\x1b[{self._lines - 1}A" if self._lines > 1 else ""
        clear = "\r" + up + "\x1b[J" if self._lines else ""
        print(clear + "\n".join(lines), end="", flush=True)
        self._lines = len(lines)


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(*heads, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    console = Console()
    if not console.is_terminal:
        console.width = 10_000  # lines in a pipe are not broken
    console.print(table)
