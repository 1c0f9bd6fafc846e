"""The verb `gecos up`: a laboratory in one command."""

from __future__ import annotations

import signal
from pathlib import Path
from types import FrameType

import click


@click.command()
@click.argument("file", required=False, type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--programs",
    "folders",
    multiple=True,
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="Folder with programs, for example the build folder of robcl; may be given several times.",
)
@click.option("--restart", is_flag=True, help="Start each program again when it ends by itself.")
def up(file: Path | None, folders: tuple[Path, ...], restart: bool) -> None:
    """Starts a laboratory: the broker and the programs of FILE, or the simulated devices of robcl.

    Without FILE, lab.toml in the current folder is used if there is one. Ctrl-C ends all programs,
    the last one first.
    """
    from gecos.cli.exit_codes import UsageFailure
    from gecos.laboratory import (
        LaboratoryFileError,
        read_laboratory,
        running,
        simulated_laboratory,
    )

    if file is None and Path("lab.toml").exists():
        file = Path("lab.toml")
    try:
        laboratory = simulated_laboratory() if file is None else read_laboratory(file)
    except LaboratoryFileError as error:
        raise UsageFailure(str(error)) from None
    for number in (signal.SIGTERM, signal.SIGHUP):  # SIGHUP arrives when a terminal is closed
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
            signal.signal(number, _interrupt)
    with running(laboratory, folders=folders, restart=restart) as started:
        names = ", ".join(program.name for program in laboratory.programs)
        verb = "is" if len(laboratory.programs) == 1 else "are"
        try:
            print(f"up: {names} {verb} ready; Ctrl-C ends them", flush=True)
            started.watch()
        except KeyboardInterrupt:
            print("up: ending", flush=True)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt
