"""Computes speeds and accelerations of a recorded motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gecos.cli.plot.recording import Numbers, Recording

MEASURED_OVER = 0.02
"""The time in s over which a measured position is differentiated. The encoders of the simulated
RX90 have a noise of 10 µrad. Over one cycle of 4 ms, this noise causes an acceleration of 1.5
rad/s²; over 20 ms, only 0.06 rad/s²."""

_STANDS_BEFORE = 0.1  # s; the picture also shows this time before and after the motion
_MOVED = 2e-4  # m; measured positions of a tool that stands differ by less
_COMMANDED = 1e-9  # rad; commanded positions of a joint that stands differ by less


@dataclass(frozen=True, slots=True)
class Course:
    """Values over time: a row for each time, a column for each joint or axis."""

    time: Numbers
    value: Numbers


def times(recording: Recording) -> Numbers:
    """Returns the time of each row in s.

    Consecutive rows are one cycle of the control loop apart. The time stamps are not used for this,
    because the loop wakes up some 0.1 ms too early or too late, and accelerations computed from the
    time stamps would magnify this error. If the cycle of the arm is unknown, or the arm does not
    send a sample in each cycle, returns the time stamps.
    """
    cycle = recording.cycle
    if cycle is None or len(recording) < 2:
        return recording.stamp
    period = np.median(np.diff(recording.stamp) / np.diff(recording.number))
    agrees = abs(period - cycle) < 0.1 * cycle
    return recording.number * cycle if agrees else recording.stamp


def slope(course: Course, over: float = 0.0) -> Course:
    """Returns the mean slopes between rows that are `over` seconds apart, or between consecutive
    rows if `over` is 0. Each slope belongs to the middle of its interval."""
    time, value = course.time, course.value
    if len(time) < 2:
        return Course(time[:0], value[:0])
    span = max(1, round(over / float(np.median(np.diff(time)))))
    took = time[span:] - time[:-span]
    rise = value[span:] - value[:-span]
    return Course((time[span:] + time[:-span]) / 2, rise / took[:, None])


@dataclass(frozen=True, slots=True)
class Motion:
    """Position, speed and acceleration of some joints, or of the tool."""

    position: Course
    speed: Course
    acceleration: Course


def _motion(time: Numbers, value: Numbers, over: float = 0.0) -> Motion:
    kept = ~np.isnan(value).any(axis=1)
    position = Course(time[kept], value[kept])
    speed = slope(position, over)
    return Motion(position, speed, slope(speed, over))


def of_joints(recording: Recording) -> Motion | None:
    """Returns the motion of the commanded joints in rad, or of the measured joints if the commanded
    ones are not known. Returns None if the arm has no joint streams."""
    if recording.commanded is not None:
        return _motion(times(recording), recording.commanded)
    if recording.joints is not None:
        return _motion(times(recording), recording.joints, MEASURED_OVER)
    return None


def of_tool(recording: Recording) -> Motion:
    """Returns the motion of the measured origin of the tool in the world, in m."""
    return _motion(times(recording), recording.tool, MEASURED_OVER)


def magnitude(course: Course) -> Course:
    """Returns the length of each row as one column. The length of a velocity is the speed."""
    return Course(course.time, np.linalg.norm(course.value, axis=1, keepdims=True))


def trimmed(recording: Recording, seconds: float | None = None) -> Recording:
    """Returns the rows from shortly before the arm begins to move until shortly after the arm
    stands, or until `seconds` after the beginning of the motion. Returns all rows if the arm does
    not move."""
    time = recording.stamp
    moves = _first_and_last(recording)
    if moves is None:
        return recording
    first, last = time[moves[0]], time[moves[1]]
    end = last + _STANDS_BEFORE if seconds is None else first + seconds
    chosen = np.flatnonzero((time >= first - _STANDS_BEFORE) & (time <= end))
    return recording.rows(slice(int(chosen[0]), int(chosen[-1]) + 1))


def _first_and_last(recording: Recording) -> tuple[int, int] | None:
    """Returns the indices of two rows: the first row in which the arm has left its initial place,
    and the last row in which the arm has not yet reached its final place. Returns None if the arm
    does not move."""
    values, least = recording.commanded, _COMMANDED
    if values is None:
        values, least = recording.tool, _MOVED
    known = np.flatnonzero(~np.isnan(values).any(axis=1))
    if not len(known):
        return None
    first, last = values[known[0]], values[known[-1]]
    left = known[(np.abs(values[known] - first) > least).any(axis=1)]
    before = known[(np.abs(values[known] - last) > least).any(axis=1)]
    return (int(left[0]), int(before[-1])) if len(left) and len(before) else None
