"""The verbs of `gecos` for the members of an object: get, set, call, watch and hz."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from typing import TYPE_CHECKING, Any

import click

from gecos.cli.exit_codes import InterruptedCommand, NotEnded, UsageFailure
from gecos.cli.options import (
    Number,
    broker_option,
    json_option,
    members,
    name_argument,
    plain,
    print_json,
    value_of,
)
from gecos.errors import DeadlineMissed, Detail, State

if TYPE_CHECKING:
    from gecos.command import Command
    from gecos.dynamic_client import DynamicObject
    from gecos.interface import Access
    from gecos.stream import Sample

password_option = click.option(
    "--password",
    default="",
    envvar="GECOS_PASSWORD",
    show_envvar=True,
    help="Share the status with clients that give the same password. The list of processes shows "
    "the arguments of a program to all users, but not its environment.",
)
timeout_option = click.option(
    "--timeout", type=Number(), help="Seconds to wait; the default is no limit."
)
attribute_argument = click.argument(
    "attribute", shell_complete=members(lambda m: m.kind == "attribute" and m.can_be_read)
)
settable_argument = click.argument(
    "attribute", shell_complete=members(lambda m: m.kind == "attribute" and m.can_be_set)
)
watched_argument = click.argument(
    "attribute",
    required=False,
    shell_complete=members(lambda m: m.kind != "operation" and (m.can_be_read or m.can_be_watched)),
)
stream_argument = click.argument(
    "stream",
    shell_complete=members(lambda m: m.kind != "operation" and m.can_be_watched),
)
operation_argument = click.argument(
    "operation", shell_complete=members(lambda m: m.kind == "operation")
)
_CANCELED_WITHIN = 1.0  # s in which a command must end after the request to cancel it
_REDRAW = 0.1  # s between two drawings of a progress bar


@contextmanager
def _connected(broker: str | None, name: str, member: str) -> Iterator[DynamicObject]:
    """Connects to the object called `name`, with a proxy that has only the member `member`."""
    import gecos
    from gecos.dynamic_client.by_name import UnknownMemberError
    from gecos.dynamic_client.connect import connect

    with gecos.Lab(broker) as lab:
        robot = connect(lab, name, only=(member,))
        try:
            yield robot
        except UnknownMemberError as error:
            raise UsageFailure(str(error)) from None


def with_status(
    robot: DynamicObject, needed: Access, password: str
) -> AbstractContextManager[object]:
    """Returns a context in which this program holds the status that a call needs."""
    import gecos

    match needed.name:
        case "MASTER":
            return gecos.master(robot, password)
        case "ACTOR":
            return gecos.actor(robot, password)
    return nullcontext()


@click.command()
@name_argument
@attribute_argument
@password_option
@timeout_option
@broker_option
@json_option
def get(
    name: str,
    attribute: str,
    password: str,
    timeout: float | None,
    broker: str | None,
    as_json: bool,
) -> None:
    """Reads an attribute. Acquires the status that reading needs."""
    from gecos.dynamic_client import by_name

    with _connected(broker, name, attribute) as robot:
        wanted = by_name.attribute(robot, attribute)
        with with_status(robot, wanted.access, password):
            value = _reading(robot, attribute, timeout)
        unit = wanted.result.unit
    if as_json:
        print_json({"name": name, "attribute": attribute, "value": value, "unit": unit})
    else:
        from gecos.cli import report

        report.value(value, unit)


def _reading(robot: DynamicObject, attribute: str, timeout: float | None) -> Any:
    """Returns the value of an attribute. Raises NotEnded after `timeout`."""
    from gecos.dynamic_client import by_name

    label = f"reading {robot._gecos_session.object_name}.{attribute}"
    return _ends(by_name.read(robot, attribute), label, timeout, shows=False).result(0)


@click.command("set", context_settings={"ignore_unknown_options": True})  # for values such as -1
@name_argument
@settable_argument
@click.argument("value")
@password_option
@timeout_option
@broker_option
@json_option
def set_(
    name: str,
    attribute: str,
    value: str,
    password: str,
    timeout: float | None,
    broker: str | None,
    as_json: bool,
) -> None:
    """Sets an attribute. VALUE is JSON, or the name of an enumerator.

    Ctrl-C, or the end of --timeout, cancels the command if it has not started.
    """
    from gecos.dynamic_client import by_name

    with _connected(broker, name, attribute) as robot:
        needed = by_name.attribute(robot, attribute).write_access
        with with_status(robot, needed, password):
            command = by_name.write(robot, attribute, value_of(value))
            _ends(command, f"{name}.{attribute}", timeout, shows=False).result(0)
    if as_json:
        print_json({"name": name, "attribute": attribute, "state": "FINISHED"})
    else:
        print(f"{name}: {attribute} is set")


@click.command()
@name_argument
@operation_argument
@click.argument("arguments", nargs=-1, metavar="[JSON | PARAMETER=VALUE...]")
@password_option
@timeout_option
@broker_option
@json_option
def call(
    name: str,
    operation: str,
    arguments: tuple[str, ...],
    password: str,
    timeout: float | None,
    broker: str | None,
    as_json: bool,
) -> None:
    """Calls an operation and waits for its end.

    The arguments are one JSON object, '{"width": 0.05}', or PARAMETER=VALUE for each parameter. The
    status that the operation needs is held during the call. Ctrl-C, or the end of --timeout,
    cancels the call if the operation is cancelable; otherwise the call continues.
    """
    from gecos.dynamic_client import by_name
    from gecos.interface import Access

    given = _arguments(arguments)
    with _connected(broker, name, operation) as robot:
        called = by_name.operation(robot, operation)
        needed = Access.SENSOR if called.safety else called.access
        with with_status(robot, needed, password):
            try:
                command = by_name.call(robot, operation, given)
            except TypeError as error:  # a parameter is missing or unknown
                raise UsageFailure(str(error)) from None
            label, shows = f"{name}.{operation}", called.cancelable and not as_json
            paused = _PauseNotice(command, name, bool(password)) if called.feedback else None
            ended = _ends(command, label, timeout, shows, paused)
            value = ended.result(0)
    if as_json:
        print_json({"name": name, "operation": operation, "state": "FINISHED", "result": value})
    elif called.outputs:
        from gecos.cli import report

        report.value(value, called.outputs[0].unit if len(called.outputs) == 1 else "")
    else:
        print(f"{name}.{operation}: FINISHED")


def _arguments(words: tuple[str, ...]) -> dict[str, Any]:
    from gecos.wire import json as gecos_json

    if len(words) == 1 and words[0].lstrip().startswith("{"):
        try:
            given: dict[str, Any] = gecos_json.plain(words[0])
        except gecos_json.JsonError as error:
            raise UsageFailure(f"arguments: {error}") from None
        return given
    found: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or not name:
            raise click.BadParameter(
                f"{word!r} is neither a JSON object nor PARAMETER=VALUE; 'gecos describe NAME' "
                "shows the parameters",
                param_hint="arguments",
            )
        if name in found:
            raise click.BadParameter(f"{name} is given twice", param_hint="arguments")
        found[name] = value_of(value)
    return found


class _PauseNotice:
    """Prints once that a command is paused. A command is paused if its feedback has a member
    `speed_override` with the value 0, for example a motion of an arm after override_speed(0). @pre
    the operation has feedback"""

    def __init__(self, command: Command[Any, Any], name: str, shared: bool) -> None:
        self._command = command
        self._said = False
        again = f"gecos call {name} override_speed factor=1"
        todo = (
            f"{again} with the same --password lets it go on"
            if shared
            else f"end this call, and set the factor by {again}"
        )
        self._text = f"{name} is paused, because its speed_override is 0; {todo}"

    def look(self, before: str = "") -> None:
        """Prints `before` and the notice, if the command is paused and the notice was not printed
        before."""
        feedback = None if self._said else self._command.feedback()
        if not feedback or feedback.get("speed_override") != 0:
            return
        self._said = True
        click.echo(before + self._text, err=True)


def _ends(
    command: Command[Any, Any],
    label: str,
    timeout: float | None,
    shows: bool,
    paused: _PauseNotice | None = None,
) -> Command[Any, Any]:
    """Waits for the end of a command and returns the command. After `timeout`, asks the server to
    cancel the command; then raises NotEnded if the command was canceled or still runs, and returns
    the command if it has ended in another way. On Ctrl-C, asks the server to cancel the command and
    raises InterruptedCommand."""
    try:
        if _ended_within(command, label, timeout, shows, paused):
            return command
    except KeyboardInterrupt:
        detail = _canceled(command)
        text = f"interrupted: {label} {_became(detail, command)}"
        raise InterruptedCommand(detail, text) from None
    detail = _canceled(command)
    if detail.state is State.RUNNING or detail is Detail.CANCELED:
        became = _became(detail, command)
        raise NotEnded(detail, f"{label} has not ended within {timeout} s and {became}")
    return command


def _canceled(command: Command[Any, Any]) -> Detail:
    """Asks the server to cancel a command. Returns how the command ended, or its state if it still
    runs."""
    command.cancel()
    command.wait(_CANCELED_WITHIN)
    return command.progress().detail


def _became(detail: Detail, command: Command[Any, Any]) -> str:
    match detail:
        case Detail.DONE:
            return "has finished"
        case Detail.CANCELED:
            return "was canceled"
        case Detail.CANCELING:
            return "is still being canceled"
        case Detail.SENT | Detail.UNREACHABLE:
            return "may go on: its server does not answer"
        case Detail.QUEUED | Detail.EXECUTING:
            return "goes on"
    return f"has ended: {command.exception()}"


def _ended_within(
    command: Command[Any, Any],
    label: str,
    timeout: float | None,
    shows: bool,
    paused: _PauseNotice | None,
) -> bool:
    """Waits for the end of a command, and shows a progress bar on a terminal. Returns whether the
    command ended in time."""
    end = None if timeout is None else time.monotonic() + timeout
    if not (shows and sys.stderr.isatty()):
        while paused and command.wait(_next_look(end)) is State.RUNNING:
            paused.look()
            if end is not None and time.monotonic() >= end:
                return False
        return command.wait(timeout) is not State.RUNNING
    with click.progressbar(length=1000, label=label, file=sys.stderr, show_eta=False) as drawn:
        while command.wait(_REDRAW) is State.RUNNING:
            drawn.update(max(0, int(command.progress().fraction * 1000) - drawn.pos))
            if paused:
                paused.look("\n")
            if end is not None and time.monotonic() >= end:
                return False
        drawn.update(1000 - drawn.pos if command.state is State.FINISHED else 0)
    return True


def _next_look(end: float | None) -> float:
    return _REDRAW if end is None else min(_REDRAW, max(0.0, end - time.monotonic()))


@click.command()
@name_argument
@watched_argument
@click.option(
    "--count",
    type=click.IntRange(min=1),
    help="End after this number of values or, without ATTRIBUTE, of changes.",
)
@click.option(
    "--every",
    type=Number(0.01),
    default=1.0,
    show_default=True,
    help="Seconds between two readings of an attribute that is not a stream.",
)
@click.option(
    "--timeout", type=Number(), help="Seconds to wait for each value; the default is no limit."
)
@password_option
@broker_option
@json_option
def watch(
    name: str,
    attribute: str | None,
    count: int | None,
    every: float,
    timeout: float | None,
    password: str,
    broker: str | None,
    as_json: bool,
) -> None:
    """Shows an attribute again and again: the samples of its stream, or repeated readings. Shows
    the arguments of an event each time it occurs. Without ATTRIBUTE, shows who holds actor or
    master status, now and after each change.

    On a terminal, each value of an attribute replaces the previous one. Each event is printed on a
    line of its own, and so is each value if the output is a pipe.
    """
    from gecos.cli import report
    from gecos.dynamic_client import by_name

    if attribute is None:
        _watch_holders(name, count, timeout, broker, as_json)
        return
    with ExitStack() as opened:
        robot = opened.enter_context(_connected(broker, name, attribute))
        wanted = by_name.attribute_or_event(robot, attribute)
        opened.enter_context(with_status(robot, wanted.access, password))
        samples = report.Samples(as_json, wanted.result.unit, replace=not wanted.event)
        shown = opened.enter_context(samples)
        for number, sample in enumerate(_samples(robot, attribute, every, timeout), 1):
            shown.show(sample)
            if number == count:
                return


def _watch_holders(
    name: str, count: int | None, timeout: float | None, broker: str | None, as_json: bool
) -> None:
    import gecos
    from gecos.cli import report
    from gecos.cli.holders import rosters
    from gecos.dynamic_client.connect import find

    with gecos.Lab(broker) as lab:
        changes = 0
        for number, told in enumerate(rosters(find(lab, name), timeout)):
            if as_json:
                print_json(plain(told))
            elif number == 0:
                report.holders(name, told.holders)
            for change in [] if as_json else told.changes:
                report.roster_change(change)
            changes += len(told.changes)
            if count is not None and changes >= count:  # several changes may come at once
                return


def _samples(
    robot: DynamicObject, attribute: str, every: float, timeout: float | None
) -> Iterator[dict[str, Any]]:
    """Yields each sample of a stream, or repeated readings. Raises TimeoutError if a sample or
    reading takes longer than `timeout`."""
    from gecos.dynamic_client import by_name

    if by_name.attribute_or_event(robot, attribute).stream is not None:
        with _subscribed(robot, attribute) as stream:
            while True:
                with suppress(DeadlineMissed):  # the stream goes on
                    yield sample_json(stream.next(timeout))
    while True:
        yield {"value": _reading(robot, attribute, timeout)}
        time.sleep(every)


@contextmanager
def _subscribed(robot: DynamicObject, attribute: str) -> Iterator[Any]:
    from gecos.dynamic_client import by_name

    stream = by_name.subscribe(robot, attribute)
    try:
        yield stream
    finally:
        stream.close()


def sample_json(sample: Sample[Any]) -> dict[str, Any]:
    return {
        "value": sample.value,
        "sequence": sample.sequence,
        "lost": sample.lost,
        "stamp": sample.stamp,
        "age": sample.age,
    }


@click.command()
@name_argument
@stream_argument
@click.option("--count", type=click.IntRange(min=1), help="End after this number of lines.")
@click.option(
    "--window",
    type=Number(0.1),
    default=1.0,
    show_default=True,
    help="Seconds of measurement for each line.",
)
@broker_option
@json_option
def hz(
    name: str, stream: str, count: int | None, window: float, broker: str | None, as_json: bool
) -> None:
    """Measures the rate of a stream: samples per second, shortest and longest period, lost samples.

    A period is the time between two measurements at the server, so the speed of this program has no
    influence.
    """
    with _connected(broker, name, stream) as robot, _subscribed(robot, stream) as opened:
        lines = 0
        last: float | None = None
        while count is None or lines < count:
            line, last = _rate(opened, window, last)
            lines += 1
            if as_json:
                print_json(line)
            else:
                from gecos.cli import report

                report.rate(line)


def _rate(stream: Any, window: float, last: float | None) -> tuple[dict[str, Any], float | None]:
    """Returns the rate of a stream within `window` seconds, with its counts and periods, and the
    stamp of the last sample. `last` is the stamp of the last sample before the window. It is None
    in the first window: the first sample then only begins the window, because it may be older than
    the window."""
    start = time.monotonic()
    samples, lost, periods = 0, 0, []
    while (left := start + window - time.monotonic()) > 0:
        try:
            sample = stream.next(left)
        except DeadlineMissed:
            continue
        except TimeoutError:
            break
        if last is None:
            last, start = sample.stamp, time.monotonic()
            continue
        samples += 1
        lost += sample.lost
        if not sample.lost:
            periods.append(sample.stamp - last)
        last = sample.stamp
    line = {
        "rate": (samples + lost) / (time.monotonic() - start),
        "samples": samples,
        "lost": lost,
        "min_period": min(periods, default=None),
        "max_period": max(periods, default=None),
    }
    return line, last
