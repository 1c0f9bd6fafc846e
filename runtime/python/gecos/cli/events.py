"""The verb `gecos events`."""

from __future__ import annotations

import threading
from collections.abc import Generator, Sequence
from contextlib import ExitStack, closing
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import click

from gecos.cli.exit_codes import UsageFailure
from gecos.cli.members import password_option, sample_json, with_status
from gecos.cli.options import broker_option, json_option, members, name_argument, print_json

if TYPE_CHECKING:
    from gecos.dynamic_client import DynamicObject
    from gecos.dynamic_client.model import Attribute
    from gecos.stream import Sample, Stream

# Longest wait in s. A signal that arrives just before Python begins to wait is handled only after
# the wait.
_LOOK_ANYWAY = 0.5
_MOST_AHEAD = 64  # events that are read before the previous ones are printed
_Heard = tuple[str, "Sample[Any] | Exception"]


@click.command()
@name_argument
@click.argument(
    "wanted",
    metavar="[EVENT]...",
    nargs=-1,
    shell_complete=members(lambda m: m.kind == "event"),
)
@click.option("--count", type=click.IntRange(min=1), help="End after this number of events.")
@password_option
@broker_option
@json_option
def events(
    name: str,
    wanted: tuple[str, ...],
    count: int | None,
    password: str,
    broker: str | None,
    as_json: bool,
) -> None:
    """Prints the events of an object as they occur, each on a line. Without names, prints all
    events that need no status."""
    import gecos
    from gecos.cli import report
    from gecos.dynamic_client import by_name
    from gecos.dynamic_client.connect import connect

    with gecos.Lab(broker) as lab, ExitStack() as opened:
        robot = connect(lab, name)
        chosen = _chosen(robot, wanted)
        opened.enter_context(with_status(robot, max(each.access for each in chosen), password))
        streams = {
            each.name: opened.enter_context(by_name.subscribe(robot, each.name)) for each in chosen
        }
        heard = opened.enter_context(closing(_heard(streams)))
        for number, (event, sample) in enumerate(heard, 1):
            if as_json:
                print_json({"event": event} | sample_json(sample))
            else:
                report.event(event, sample)
            if number == count:
                return


def _chosen(robot: DynamicObject, wanted: Sequence[str]) -> list[Attribute]:
    model = robot._gecos_model
    known = {m.name: m for m in model.members if m.kind == "event"}
    where = f"{robot._gecos_session.object_name} ({model.interface})"
    for each in wanted:
        if each not in known:
            there = ", ".join(known) or "none"
            raise UsageFailure(f"{where} has no event {each!r}; it has {there}")
    chosen = [m for m in known.values() if (m.name in wanted if wanted else m.access == 0)]
    if not chosen:
        named = ", ".join(known)
        raise UsageFailure(
            f"all events of {where} need a status; name those to print: {named}"
            if known
            else f"{where} has no events"
        )
    return chosen  # type: ignore[return-value]  # an event is an Attribute


def _heard(streams: dict[str, Stream[Any]]) -> Generator[tuple[str, Sample[Any]]]:
    """Yields the events of all streams; a separate thread reads each stream. If reading a stream
    raises an exception, raises this exception. The threads read at most _MOST_AHEAD events, and one
    more of each stream, before the caller uses them. A stream counts the events that it loses while
    its thread waits for the caller."""
    queue: SimpleQueue[_Heard] = SimpleQueue()
    places = threading.Semaphore(_MOST_AHEAD)

    def read(event: str, stream: Stream[Any]) -> None:
        try:
            for sample in stream:
                queue.put((event, sample))
                places.acquire()
        except Exception as error:
            queue.put((event, error))

    threads = [threading.Thread(target=read, args=each) for each in streams.items()]
    for thread in threads:
        thread.start()
    try:
        while True:
            try:
                event, sample = queue.get(timeout=_LOOK_ANYWAY)
            except Empty:
                continue
            if isinstance(sample, Exception):
                raise sample
            yield event, sample
            places.release()
    finally:
        for stream in streams.values():
            stream.close()
        places.release(len(threads))  # each thread waits for a place at most once more
        for thread in threads:
            thread.join()
