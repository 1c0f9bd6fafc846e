"""A recorded motion, and the file in which it is stored."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gecos.cli.exit_codes import UsageFailure

Numbers = npt.NDArray[np.float64]

_FIRST_LINE = "# gecos plot 1"
_TOOL = ("tool_x_m", "tool_y_m", "tool_z_m")
_OWN_FILES = "give a file that `gecos plot NAME --csv FILE` has written"


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """The samples of one motion. Each row has the samples of one cycle of the control loop; a
    sample that was lost is NaN."""

    name: str
    interface: str
    cycle: float | None
    """The period of the control loop in s; None if it is unknown."""
    number: Numbers
    """Sequence number of each row, counted from the first row. A gap in these numbers means that a
    row was lost."""
    stamp: Numbers
    """Time of measurement in s since the first row, by the clock of the server; simulated time if
    the laboratory does not run in real time."""
    tool: Numbers
    """Measured origin of the tool in the world in m: x, y and z of each row."""
    joints: Numbers | None
    """Measured joint positions in rad, a column for each joint; None for an arm that has no such
    stream."""
    commanded: Numbers | None
    """Commanded joint positions in rad, a column for each joint; None for an arm that has no such
    stream."""
    lost: Mapping[str, int]
    """Samples that were lost, by the name of the stream."""
    missed_cycles: int
    """Cycles that the control loop missed during the recording."""

    def __len__(self) -> int:
        return len(self.number)

    @property
    def joint_count(self) -> int:
        """Number of joints; 0 if the arm has no joint streams."""
        values = self.commanded if self.commanded is not None else self.joints
        return 0 if values is None else values.shape[1]

    def rows(self, chosen: slice) -> Recording:
        """Returns the part of the recording that consists of some rows. Times and numbers count
        from the first of these rows."""
        number, stamp = self.number[chosen], self.stamp[chosen]
        return Recording(
            name=self.name,
            interface=self.interface,
            cycle=self.cycle,
            number=number - number[:1],
            stamp=stamp - stamp[:1],
            tool=self.tool[chosen],
            joints=None if self.joints is None else self.joints[chosen],
            commanded=None if self.commanded is None else self.commanded[chosen],
            lost=self.lost,
            missed_cycles=self.missed_cycles,
        )


def write_csv(recording: Recording, path: Path) -> None:
    """Writes a recording as a table. Its first two lines are comments: the version of the format,
    and the data that are not in the table, as JSON."""
    facts = {
        "name": recording.name,
        "interface": recording.interface,
        "cycle_s": recording.cycle,
        "lost": dict(recording.lost),
        "missed_cycles": recording.missed_cycles,
    }
    heads = ["number", "stamp_s", *_TOOL]
    columns = [recording.number[:, None], recording.stamp[:, None], recording.tool]
    for values, prefix in ((recording.joints, "joint"), (recording.commanded, "commanded")):
        if values is not None:
            heads += _joint_heads(prefix, values.shape[1])
            columns.append(values)
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(f"{_FIRST_LINE}\n# {json.dumps(facts)}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(heads)
        for row in np.hstack(columns):
            number, stamp, *values = row.tolist()
            table.writerow([int(number), f"{stamp:.6f}", *map(_cell, values)])


def _joint_heads(prefix: str, joints: int) -> list[str]:
    return [f"{prefix}{i}_rad" for i in range(1, joints + 1)]


def _cell(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.9g}"


def read_csv(path: Path) -> Recording:
    """Reads a file that `write_csv` has written. For any other file, raises UsageFailure, which
    names the wrong line. Raises OSError if the file cannot be read."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError:
        raise UsageFailure(f"{path}: this is no text in UTF-8; {_OWN_FILES}") from None
    if not lines or lines[0] != _FIRST_LINE:
        raise UsageFailure(f"{path}:1: the line is not {_FIRST_LINE!r}; {_OWN_FILES}")
    if len(lines) < 3:
        raise UsageFailure(f"{path}:{len(lines)}: the file ends before its table; {_OWN_FILES}")
    facts = _facts(lines[1], f"{path}:2")
    heads = lines[2].split(",")
    joints = _joints_of(heads, "joint"), _joints_of(heads, "commanded")
    expected = ["number", "stamp_s", *_TOOL]
    for prefix, count in zip(("joint", "commanded"), joints, strict=True):
        expected += _joint_heads(prefix, count)
    if heads != expected:
        raise UsageFailure(f"{path}:3: the columns are not {', '.join(expected)}; {_OWN_FILES}")
    table = np.array(list(_rows(lines[3:], heads, path))).reshape(-1, len(heads))
    measured, commanded = table[:, 5 : 5 + joints[0]], table[:, 5 + joints[0] :]
    return Recording(
        number=table[:, 0],
        stamp=table[:, 1],
        tool=table[:, 2:5],
        joints=measured if joints[0] else None,
        commanded=commanded if joints[1] else None,
        **facts,
    )


def _joints_of(heads: Sequence[str], prefix: str) -> int:
    return sum(head.startswith(prefix) for head in heads)


def _facts(line: str, where: str) -> dict[str, Any]:
    try:
        read = json.loads(line.removeprefix("#"))
        cycle = read["cycle_s"]
        return {
            "name": str(read["name"]),
            "interface": str(read["interface"]),
            "cycle": None if cycle is None else float(cycle),
            "lost": {str(stream): int(count) for stream, count in read["lost"].items()},
            "missed_cycles": int(read["missed_cycles"]),
        }
    except (ValueError, KeyError, TypeError, AttributeError):
        raise UsageFailure(
            f"{where}: the line does not describe a recording; {_OWN_FILES}"
        ) from None


def _rows(lines: Sequence[str], heads: Sequence[str], path: Path) -> Iterator[list[float]]:
    last = (-np.inf, -np.inf)
    for at, line in enumerate(lines, 4):
        cells = line.split(",")
        if len(cells) != len(heads):
            raise UsageFailure(f"{path}:{at}: {len(cells)} values, not {len(heads)}; {_OWN_FILES}")
        row = [_number(*each, f"{path}:{at}") for each in zip(heads, cells, strict=True)]
        if not (row[0] > last[0] and row[1] > last[1]):
            raise UsageFailure(
                f"{path}:{at}: number and stamp_s do not increase from the line before; "
                f"{_OWN_FILES}"
            )
        last = row[0], row[1]
        yield row


def _number(head: str, cell: str, where: str) -> float:
    """Returns the number in a cell of the column `head`. An empty cell stands for a lost sample and
    is returned as NaN; the cells of "number" and "stamp_s" must not be empty. Raises
    UsageFailure."""
    try:
        value = float(cell) if cell or head in ("number", "stamp_s") else np.nan
    except ValueError:
        value = np.inf
    if np.isinf(value) or (cell and np.isnan(value)):
        raise UsageFailure(f"{where}: {head} is {cell!r}, which is no finite number; {_OWN_FILES}")
    return value
