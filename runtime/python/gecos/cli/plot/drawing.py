"""Draws a recorded motion with matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gecos.cli.plot.limits import ArmLimits
from gecos.cli.plot.motion import Course, Motion, magnitude, of_joints, of_tool, times
from gecos.cli.plot.recording import Recording

_MOST_POINTS = 300
"""The greatest number of points of a line in the picture, so that the file stays small."""
_PLANES = (("top view", 0, 1), ("side view", 0, 2), ("front view", 1, 2))
_SETTINGS: dict[Any, Any] = {
    "svg.hashsalt": "gecos plot",  # the same picture gives the same file
    "svg.fonttype": "none",  # text is not converted to curves
    "path.simplify_threshold": 0.4,
    "font.size": 8.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
}
_NO_DATE = {".svg": {"Date": None, "Creator": None}, ".png": {"Software": None}}
_LIMIT: dict[str, Any] = {"color": "black", "linewidth": 0.8, "linestyle": "--"}


def draw(recording: Recording, limits: ArmLimits | None, path: Path) -> None:
    """Draws a recording into a file: on the left the joints, or the tool of an arm without joint
    streams; on the right the path of the tool; at the bottom the speed and acceleration of the
    tool. The same recording gives the same file. Raises OSError."""
    with matplotlib.rc_context(_SETTINGS):
        figure = Figure(figsize=(10, 10), layout="constrained")
        axes = figure.subplots(4, 2)
        _title(figure, recording)
        tool = of_tool(recording)
        joints = of_joints(recording)
        if joints is None:
            _tool_over_time(axes[:3, 0], tool)
        else:
            commanded = recording.commanded is not None
            _joints_over_time(axes[:3, 0], joints, limits, commanded)
        for plane, (title, across, up) in zip(axes[:3, 1], _PLANES, strict=True):
            _path(plane, tool.position, title, across, up)
        _length(
            axes[3, 0], tool.speed, "tool speed, m/s", None if limits is None else limits.tool_speed
        )
        _length(
            axes[3, 1],
            tool.acceleration,
            "tool acceleration, m/s²",
            None if limits is None else limits.tool_acceleration,
        )
        figure.savefig(path, metadata=_NO_DATE[path.suffix])


def _title(figure: Figure, recording: Recording) -> None:
    lost = sum(recording.lost.values())
    words = [f"{recording.name} ({recording.interface})", f"{times(recording)[-1]:.2f} s"]
    words.append(f"{lost} samples lost" if lost else "no sample lost")
    if recording.missed_cycles:
        words.append(f"{recording.missed_cycles} cycles missed by the control loop")
    figure.suptitle(", ".join(words), fontsize=10)


def _joints_over_time(
    axes: np.ndarray[tuple[int], np.dtype[np.object_]],
    joints: Motion,
    limits: ArmLimits | None,
    commanded: bool,
) -> None:
    """Draws the positions, speeds and accelerations of the joints over time. If the limits are
    known, speeds and accelerations are drawn in percent of the limit of each joint. The picture
    then shows which joint is at its limit."""
    positions, speeds, accelerations = axes
    which = "commanded" if commanded else "measured"
    _lines(positions, _scaled(joints.position, 180 / np.pi), f"{which} joints, °", "joint")
    positions.legend(ncols=6, fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    if limits is not None:
        _travel(positions, limits)
    _shares(speeds, joints.speed, "speed", "°/s", None if limits is None else limits.speed)
    _shares(
        accelerations,
        joints.acceleration,
        "acceleration",
        "°/s²",
        None if limits is None else limits.acceleration,
    )


def _shares(
    axes: Axes,
    course: Course,
    what: str,
    unit: str,
    limit: np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None,
) -> None:
    if limit is None:
        _lines(axes, _scaled(course, 180 / np.pi), f"joint {what}, {unit}")
        return
    _lines(axes, Course(course.time, course.value / limit * 100), f"joint {what}, % of its limit")
    for share in (-100, 100):
        axes.axhline(share, **_LIMIT)


def _travel(axes: Axes, limits: ArmLimits) -> None:
    """Draws each limit of a joint position that is within the range of the axes, or at most 20°
    outside it."""
    bottom, top = axes.get_ylim()
    for i, ends in enumerate(zip(limits.lower, limits.upper, strict=True)):
        for end in np.degrees(ends):
            if bottom - 20 < end < top + 20:
                axes.axhline(end, color=f"C{i}", linewidth=0.8, linestyle="--")


def _tool_over_time(axes: np.ndarray[tuple[int], np.dtype[np.object_]], tool: Motion) -> None:
    names = iter(("x", "y", "z"))
    positions, speeds, accelerations = axes
    _lines(positions, _scaled(tool.position, 1e3), "tool in the world, mm", "", names)
    positions.legend(ncols=3, fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    _lines(speeds, tool.speed, "along x, y, z, m/s")
    _lines(accelerations, tool.acceleration, "along x, y, z, m/s²")


def _lines(
    axes: Axes, course: Course, label: str, each: str = "", names: Iterator[str] | None = None
) -> None:
    names = names or (f"{each} {i}" if each else "" for i in range(1, course.value.shape[1] + 1))
    few = _thinned(course)
    for column, name in zip(few.value.T, names, strict=True):
        axes.plot(few.time, column, label=name)
    axes.set_ylabel(label)
    axes.set_xlabel("time, s")


def _length(axes: Axes, course: Course, label: str, limit: float | None) -> None:
    _lines(axes, magnitude(course), f"{label} (measured)")
    if limit is not None:
        axes.axhline(limit, **_LIMIT)
    axes.set_ylim(bottom=0)


def _path(axes: Axes, position: Course, title: str, across: int, up: int) -> None:
    """Draws the path of the tool in one view. The axes of all views have the same scale. Otherwise
    the noise across a straight line would be magnified."""
    axes.set_title(f"path of the tool, {title}", fontsize=8)
    axes.set_xlabel(f"{'xyz'[across]}, mm")
    axes.set_ylabel(f"{'xyz'[up]}, mm")
    few = _thinned(_scaled(position, 1e3))
    if not len(few.time):  # all samples were lost
        return
    axes.plot(few.value[:, across], few.value[:, up])
    axes.plot(*few.value[0, [across, up]], "o", color="C2", markersize=4)
    axes.plot(*few.value[-1, [across, up]], "s", color="C3", markersize=4)
    lower, upper = few.value.min(axis=0), few.value.max(axis=0)
    middle, half = (lower + upper) / 2, max(1.0, 0.55 * float((upper - lower).max()))
    axes.set_xlim(middle[across] - half, middle[across] + half)
    axes.set_ylim(middle[up] - half, middle[up] + half)
    axes.set_aspect("equal", adjustable="box")


def _scaled(course: Course, factor: float) -> Course:
    return Course(course.time, course.value * factor)


def _thinned(course: Course) -> Course:
    """Keeps every n-th row, and the last one."""
    rows = len(course.time)
    step = max(1, -(-rows // _MOST_POINTS))
    kept = np.union1d(np.arange(0, rows, step), np.arange(rows)[-1:])
    return Course(course.time[kept], course.value[kept])
