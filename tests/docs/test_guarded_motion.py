"""`move_guarded` of lesson 3, with a robot and a laser that are not there."""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

import gecos
import pytest
from pages import blocks_of
from robcl.frames import Frame
from robcl.laser_distance_sensor import Distance

Function = Callable[[Any, Frame, Any], bool]
FAILED = gecos.ConnectionFailed(gecos.Detail.NO_SERVER, "its server is gone")


class Motion:
    """A command that has ended with `failure`, or has finished."""

    def __init__(self, failure: gecos.CommandFailed | gecos.ConnectionFailed | None) -> None:
        self._failure = failure

    def wait(self, timeout: float) -> gecos.State:
        return gecos.State.FINISHED if self._failure is None else gecos.State.COMMAND_FAILED

    def exception(self) -> gecos.CommandFailed | gecos.ConnectionFailed | None:
        return self._failure

    def result(self) -> None:
        if self._failure is not None:
            raise self._failure


class Robot:
    def __init__(self, failure: gecos.CommandFailed | gecos.ConnectionFailed | None) -> None:
        self.moves = 0
        self._failure = failure

    def move(self, goal: Frame, how: object) -> Motion:
        self.moves += 1
        return Motion(self._failure)


class Beam:
    def __init__(self, *, broken: bool) -> None:
        self._broken = broken

    def latest(self) -> gecos.Sample[Distance]:
        return gecos.Sample(Distance(valid=self._broken), sequence=1, lost=0, stamp=0.0, age=0.0)


@pytest.fixture(scope="module")
def move_guarded() -> Function:
    lesson = types.ModuleType("guarded")
    (code,) = (
        block.text
        for block in blocks_of("docs/tutorial/3-sensor-and-motion.md")
        if block.file == "guarded.py"
    )
    exec(compile(code, "guarded.py", "exec"), vars(lesson))
    function: Function = lesson.move_guarded
    return function


def test_a_motion_that_finishes_is_done(move_guarded: Function) -> None:
    assert move_guarded(Robot(None), Frame(), Beam(broken=False))


@pytest.mark.parametrize("failure", [FAILED, gecos.CommandFailed(gecos.Detail.STOPPED, "by ann")])
def test_a_motion_that_did_not_start_or_was_stopped_is_told(
    failure: gecos.CommandFailed | gecos.ConnectionFailed, move_guarded: Function
) -> None:
    with pytest.raises(type(failure)):
        move_guarded(Robot(failure), Frame(), Beam(broken=False))


def test_a_motion_that_was_canceled_is_not_done(move_guarded: Function) -> None:
    canceled = gecos.CommandFailed(gecos.Detail.CANCELED, "canceled")
    assert not move_guarded(Robot(canceled), Frame(), Beam(broken=False))


def test_no_motion_is_issued_into_a_broken_beam(move_guarded: Function) -> None:
    robot = Robot(None)
    assert not move_guarded(robot, Frame(), Beam(broken=True))
    assert robot.moves == 0
