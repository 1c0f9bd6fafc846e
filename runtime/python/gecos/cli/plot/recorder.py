"""Records the streams of an arm while it moves."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gecos.cli.exit_codes import UsageFailure
from gecos.cli.plot.recording import Recording
from gecos.dynamic_client import by_name
from gecos.errors import CommandFailed, ConnectionFailed, StreamLost

if TYPE_CHECKING:
    from gecos.dynamic_client import DynamicObject
    from gecos.stream import Sample, Stream

_JOINTS = ("joints", "commanded_joints")
_JOINTED = {"robcl::SixAxis", "robcl::ArticulatedArm"}
_BEFORE = 1.0  # s; the age of the oldest sample that is kept before the motion begins
_LOOK = 0.02  # s between two questions whether the arm moves
_STANDS_FOR = 0.3
"""The recording ends when the arm has stood still for this time in s. Shorter stops are normal: a
program that waits for the end of each move lets the arm stand for some ms between two moves."""


class _Reader(threading.Thread):
    """Reads the samples of one stream. Before `keep()` is called, it keeps only the samples of the
    last `_BEFORE` seconds; afterwards it keeps all samples."""

    def __init__(self, stream: Stream[Any]) -> None:
        super().__init__(daemon=True)
        self.samples: deque[Sample[Any]] = deque()
        self.failure: Exception | None = None
        self._stream = stream
        self._keeps = threading.Event()

    def keep(self) -> None:
        self._keeps.set()

    def run(self) -> None:
        try:
            for sample in self._stream:
                self.samples.append(sample)
                while not self._keeps.is_set() and self._is_old(self.samples[0], sample):
                    self.samples.popleft()
        except Exception as error:
            self.failure = error

    def _is_old(self, first: Sample[Any], last: Sample[Any]) -> bool:
        return last.stamp - first.stamp > _BEFORE

    def end(self) -> None:
        self._stream.close()
        self.join()


def joint_count(robot: DynamicObject) -> int:
    """Returns the number of joints of an arm; 0 if the arm has no joint streams."""
    if _JOINTED.isdisjoint(robot._gecos_model.interfaces):
        return 0
    return len(by_name.read(robot, "joints").result()["position"])


def record(
    robot: DynamicObject, patience: float, seconds: float | None, tell: Callable[[str], None]
) -> tuple[Recording, Exception | None]:
    """Waits for the next motion of an arm. Records the motion until the arm stands, until `seconds`
    have passed, or until Ctrl-C. `seconds` and the times in the recording are simulated time, by
    the lab clock of the arm. Calls `tell` with a line when the wait begins and when the recording
    begins. If the server is lost while the arm moves, returns what was recorded and the failure.

    Raises UsageFailure if the object is not an arm, TimeoutError if the arm does not move within
    `patience`, and KeyboardInterrupt for Ctrl-C before the arm moves.
    """
    name, interface = robot._gecos_session.object_name, robot._gecos_model.interface
    if "robcl::Manipulator" not in robot._gecos_model.interfaces:
        raise UsageFailure(
            f"{name} ({interface}) is not an arm, so it has no motion to draw; "
            "`gecos ls --interface robcl::Manipulator` lists the arms"
        )
    try:
        cycle = float(by_name.read(robot, "cycle").result())
        clock = float(by_name.read(robot, "clock_speed").result())
    except by_name.UnknownMemberError as error:
        raise UsageFailure(
            f"{error}; start the server of {name} again, with this version of robcl"
        ) from None
    missed = int(by_name.read(robot, "missed_cycles").result())
    joints = joint_count(robot)
    streams = ("tool", *(_JOINTS if joints else ()))
    failure: Exception | None = None
    with contextlib.ExitStack() as opened:
        stood = opened.enter_context(by_name.subscribe(robot, "stood"))
        readers = {each: _Reader(by_name.subscribe(robot, each)) for each in streams}
        for reader in readers.values():
            opened.callback(reader.end)
            reader.start()
        tell(f"waits until {name} moves")
        _await_motion(robot, stood, patience)
        for reader in readers.values():
            reader.keep()
        try:
            with contextlib.suppress(KeyboardInterrupt):
                tell(f"records {name} until it stands" if seconds is None else f"records {name}")
                _await_end(robot, stood, readers, seconds and seconds / clock)
            missed = int(by_name.read(robot, "missed_cycles").result()) - missed
        except (StreamLost, ConnectionFailed, CommandFailed) as error:
            failure, missed = error, 0
    samples = {each: list(reader.samples) for each, reader in readers.items()}
    recording = _joined(name, interface, cycle, missed, samples, joints)
    # The stamps are real time. Simulated time follows from the sequence numbers, because a
    # simulated arm skips no cycle.
    if clock != 1:
        recording = replace(recording, stamp=recording.number * cycle)
    return recording, failure


def _stands(robot: DynamicObject) -> bool:
    return bool(by_name.read(robot, "standing").result())


def _heard(stood: Stream[Any], timeout: float) -> bool:
    try:
        stood.next(timeout)
    except TimeoutError:
        return False
    return True


def _await_motion(robot: DynamicObject, stood: Stream[Any], patience: float) -> None:
    end = time.monotonic() + patience
    while _stands(robot) and not _heard(stood, _LOOK):
        if time.monotonic() >= end:
            raise TimeoutError(
                f"{robot._gecos_session.object_name} has not moved within {patience:g} s; start "
                "the motion in another terminal while gecos plot waits, or give a longer --wait"
            )


def _await_end(
    robot: DynamicObject,
    stood: Stream[Any],
    readers: dict[str, _Reader],
    seconds: float | None,
) -> None:
    end = None if seconds is None else time.monotonic() + seconds
    standing_since: float | None = None
    while end is None or time.monotonic() < end:
        for reader in readers.values():
            if reader.failure is not None:
                raise reader.failure
        heard = _heard(stood, _LOOK)
        if seconds is not None:
            continue
        if not _stands(robot):
            standing_since = None
        elif standing_since is None or heard:
            standing_since = time.monotonic()
        elif time.monotonic() - standing_since > _STANDS_FOR:
            return


def _joined(
    name: str,
    interface: str,
    cycle: float,
    missed_cycles: int,
    samples: dict[str, list[Sample[Any]]],
    joint_count: int,
) -> Recording:
    """Combines the samples of one cycle, which have the same stamp, into one row. There is a row
    for each sample of the commanded joints, or for each sample of the tool if the arm has no joint
    streams."""
    rows = samples.get("commanded_joints", samples["tool"])
    first = rows[0] if rows else None
    columns = {
        "tool": ({s.stamp: _position(s.value) for s in samples["tool"]}, 3),
        **{
            each: ({s.stamp: s.value["position"] for s in samples[each]}, joint_count)
            for each in _JOINTS
            if each in samples
        },
    }

    def table(stream: str) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        at, width = columns[stream]
        nothing = [np.nan] * width
        found = [at.get(row.stamp, nothing) for row in rows]
        return np.array(found, dtype=np.float64).reshape(-1, width)

    return Recording(
        name=name,
        interface=interface,
        cycle=cycle,
        number=np.array([row.sequence - first.sequence for row in rows if first], dtype=np.float64),
        stamp=np.array([row.stamp - first.stamp for row in rows if first], dtype=np.float64),
        tool=table("tool"),
        joints=table("joints") if "joints" in columns else None,
        commanded=table("commanded_joints") if "commanded_joints" in columns else None,
        lost={each: sum(s.lost for s in them[1:]) for each, them in samples.items()},
        missed_cycles=missed_cycles,
    )


def _position(frame: dict[str, Any]) -> list[float]:
    at = frame["position"]
    return [at["x"], at["y"], at["z"]]
