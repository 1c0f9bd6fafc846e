"""The verb `gecos plot`."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gecos.cli.exit_codes import UsageFailure
from gecos.cli.options import (
    Number,
    broker_option,
    json_option,
    optional_name_argument,
    print_json,
)

if TYPE_CHECKING:
    from gecos.cli.plot.limits import ArmLimits
    from gecos.cli.plot.recording import Recording

_SUFFIXES = (".svg", ".png")
_FEWEST = 3  # fewest samples from which an acceleration can be computed
_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@optional_name_argument
@click.option(
    "-o",
    "--output",
    "picture",
    metavar="FILE",
    type=_FILE,
    help="Draw into this file, which ends in .svg or .png; default: NAME.svg, or no picture if "
    "--csv is given.",
)
@click.option("--csv", "table", metavar="FILE", type=_FILE, help="Write the samples as a table.")
@click.option(
    "--limits",
    "limits_file",
    metavar="FILE",
    type=_FILE,
    help="Draw the limits of ARM.toml or ARM.urdf, too.",
)
@click.option(
    "--seconds", type=Number(0.01), help="Record for this time; default: until the arm stands."
)
@click.option(
    "--wait",
    "patience",
    type=Number(),
    default=60.0,
    show_default=True,
    help="The longest time in s to wait for the arm to move.",
)
@click.option(
    "--from",
    "recorded",
    metavar="FILE",
    type=_FILE,
    help="Draw a table that --csv wrote, without recording.",
)
@broker_option
@json_option
def plot(
    name: str | None,
    picture: Path | None,
    table: Path | None,
    limits_file: Path | None,
    seconds: float | None,
    patience: float,
    recorded: Path | None,
    broker: str | None,
    as_json: bool,
) -> None:
    """Draws the next motion of an arm: joints, speeds, accelerations, and the path of the tool.

    Waits until the arm moves, and records until it stands, or until Ctrl-C. Start the motion in
    another terminal.
    """
    if (name is None) == (recorded is None):
        raise click.UsageError("give either the NAME of an arm, or --from FILE")
    if recorded is not None and (table or seconds is not None):
        raise click.UsageError("--from draws a recording as it is: leave out --csv and --seconds")
    if picture is None and table is None:
        picture = Path(f"{name}.svg") if recorded is None else recorded.with_suffix(".svg")
    if picture is not None:
        _check_suffix(picture)
        _check_matplotlib()
    for file in filter(None, (picture, table)):
        _check_writable(file)

    from gecos.cli.plot.limits import read_limits

    limits = read_limits(limits_file) if limits_file else None
    ended_by: Exception | None = None
    if recorded is not None:
        recording = _read(recorded, limits)
    else:
        assert name is not None
        recording, ended_by = _record(name, limits, patience, seconds, broker)
    if table is not None:
        from gecos.cli.plot.recording import write_csv

        write_csv(recording, table)
    if picture is not None:
        from gecos.cli.plot.drawing import draw

        draw(recording, limits, picture)
    _report(recording, picture, table, as_json)
    if ended_by is not None:
        raise ended_by


def _read(file: Path, limits: ArmLimits | None) -> Recording:
    from gecos.cli.plot.limits import check_joints
    from gecos.cli.plot.recording import read_csv

    recording = read_csv(file)
    if len(recording) < _FEWEST:
        raise UsageFailure(f"{file}: a motion has at least {_FEWEST} samples")
    if limits is not None and recording.joint_count:
        check_joints(limits, recording.name, recording.joint_count)
    return recording


def _record(
    name: str,
    limits: ArmLimits | None,
    patience: float,
    seconds: float | None,
    broker: str | None,
) -> tuple[Recording, Exception | None]:
    """Records the next motion of an arm. If the server was lost while the arm moved, also returns
    this failure."""
    import gecos
    from gecos.cli.plot.limits import check_joints
    from gecos.cli.plot.motion import trimmed
    from gecos.cli.plot.recorder import joint_count, record
    from gecos.dynamic_client.connect import connect

    with gecos.Lab(broker) as lab:
        robot = connect(lab, name)
        if limits is not None and (joints := joint_count(robot)):
            check_joints(limits, name, joints)
        recording, ended_by = record(robot, patience, seconds, _tell)
    if len(recording) < _FEWEST:
        raise ended_by or RuntimeError(
            f"{name} has sent fewer than {_FEWEST} samples while it moved; `gecos hz {name} tool` "
            "shows how many it sends"
        )
    return trimmed(recording, seconds), ended_by


def _check_suffix(picture: Path) -> None:
    if picture.suffix not in _SUFFIXES:
        raise click.BadParameter(
            f"{str(picture)!r} does not end in {' or '.join(_SUFFIXES)}", param_hint="--output"
        )


def _check_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        if error.name != "matplotlib":
            raise
        raise RuntimeError(
            "the Python package matplotlib, which draws, is missing; install it, for example by "
            "`pip install matplotlib` or `apt-get install python3-matplotlib`, or write only a "
            "table by --csv FILE"
        ) from None


def _check_writable(file: Path) -> None:
    """Before a recording begins, reports what would prevent the picture from being written
    afterwards."""
    target = file if file.exists() else file.absolute().parent
    if not target.exists():
        raise OSError(f"{file} cannot be written: there is no folder {target}; create it")
    if not os.access(target, os.W_OK):
        raise OSError(f"{file} cannot be written: {target} is write-protected; name another file")


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _report(recording: Recording, picture: Path | None, table: Path | None, as_json: bool) -> None:
    from gecos.cli.plot.motion import times
    from gecos.cli.report import printable

    took = float(times(recording)[-1])
    if as_json:
        print_json(
            {
                "name": recording.name,
                "seconds": took,
                "samples": len(recording),
                "lost": dict(recording.lost),
                "missed_cycles": recording.missed_cycles,
                "picture": None if picture is None else str(picture),
                "csv": None if table is None else str(table),
            }
        )
        return
    files = " and ".join(str(file) for file in (picture, table) if file is not None)
    lost = ", ".join(f"{count} of {stream}" for stream, count in recording.lost.items() if count)
    missed = recording.missed_cycles
    print(
        printable(
            f"{files}: {recording.name}, {took:.2f} s, {len(recording)} samples"
            + (f", lost {lost}" if lost else "")
            + (f", {missed} cycles missed by the control loop" if missed else "")
        )
    )
