"""The verb `gecos up`: a laboratory in one command."""

from __future__ import annotations

import signal
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from threading import Lock
from types import FrameType
from typing import TYPE_CHECKING

import click

from gecos.cli.options import Number, json_option, print_json

if TYPE_CHECKING:
    from gecos.laboratory import Event, LaboratoryDescription

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # SIGHUP: a terminal was closed

_LOOK_AT_FILE = 2.0  # s between two looks at the file of the laboratory


@click.command()
@click.argument("file", required=False, type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--programs",
    "folders",
    multiple=True,
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="Folder with programs, for example the build folder of robcl; may be given several times.",
)
@click.option(
    "--clock",
    "clock_speed",
    type=Number(0.1, 100_000),
    help="Simulated seconds that pass in a second, for simulated devices; default: what FILE says "
    "below [clock], else real time.",
)
@click.option("--restart", is_flag=True, help="Start each program again when it ends by itself.")
@json_option
def up(
    file: Path | None,
    folders: tuple[Path, ...],
    clock_speed: float | None,
    restart: bool,
    as_json: bool,
) -> None:
    """Starts a laboratory: the broker and the programs of FILE, or the simulated devices of robcl.

    Without FILE, lab.toml in the current folder is used if there is one. Ctrl-C ends all programs,
    the last one first; a second Ctrl-C kills those that have not ended yet.
    """
    from gecos.laboratory import Event, UnreadLists, What, running

    laboratory = _described(file)
    if clock_speed is not None:
        laboratory = replace(laboratory, clock_speed=clock_speed)
    tell = _OneLine().tell if as_json else _show
    signals = _Signals()
    unread = UnreadLists(laboratory)

    def report(event: Event) -> None:
        if event.event is What.CLOSING:
            signals.closing = True
        tell(event)

    try:
        with running(laboratory, None, folders, restart, report) as started:
            names = ", ".join(program.name for program in laboratory.programs)
            verb = "is" if len(laboratory.programs) == 1 else "are"
            clock = _about_clock(laboratory.clock_speed)
            report(Event(What.ALL_READY, f"{names} {verb} ready; {clock}Ctrl-C ends them"))
            while True:
                started.watch(_LOOK_AT_FILE)
                if told := unread.appeared():
                    report(Event(What.UNREAD_LISTS, told))
    except KeyboardInterrupt:
        if signals.insisted:
            raise


def _about_clock(speed: float | None) -> str:
    """Returns the part of a message that says how fast simulated time passes; "" in real time."""
    if speed is None or speed == 1:
        return ""
    return f"simulated time is {speed:g} times as fast as real time; "


def _described(file: Path | None) -> LaboratoryDescription:
    from gecos.cli.exit_codes import UsageFailure
    from gecos.laboratory import LaboratoryFileError, read_laboratory, simulated_laboratory

    if file is None and Path("lab.toml").exists():
        file = Path("lab.toml")
    try:
        return simulated_laboratory() if file is None else read_laboratory(file)
    except LaboratoryFileError as error:
        raise UsageFailure(str(error)) from None


class _Signals:
    """Raises KeyboardInterrupt at the first SIGINT, SIGTERM or SIGHUP. While the programs are being
    ended, only another SIGINT raises KeyboardInterrupt again, which kills the programs. Other
    signals have no further effect, because a closed terminal may send SIGHUP several times, and a
    service manager may then send SIGTERM.

    If the process ignores one of these signals from its start, as with nohup, the signal stays
    ignored.
    """

    def __init__(self) -> None:
        self.closing = False
        self.insisted = False  # SIGINT has come while the programs were being ended
        for number in _SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._arrived)

    def _arrived(self, number: int, frame: FrameType | None) -> None:
        if self.closing and number != signal.SIGINT:
            return
        self.insisted = self.closing
        self.closing = True
        raise KeyboardInterrupt


def _show(event: Event) -> None:
    from gecos.laboratory import say, show

    if event.program:
        show(event)
    else:
        say(f"up: {event.text}")


class _OneLine:
    """Prints each event as one line of JSON, even if several threads report at the same time. The
    programs continue even if no program reads the output any more."""

    def __init__(self) -> None:
        self._lock = Lock()

    def tell(self, event: Event) -> None:
        about = {
            "program": event.program or None,
            "status": event.status,
            "restarts_in": event.restarts_in,
        }
        known = {name: value for name, value in about.items() if value is not None}
        with self._lock, suppress(OSError, ValueError):
            print_json({"event": event.event, "text": event.text, **known})
