"""The laboratory in which the mistakes are made: a gripper and a laser in this process."""

from __future__ import annotations

from typing import Any

import gecos
from robcl.frames import Frame
from robcl.gripper import GripperServant, GripperState, WidthOutOfRange
from robcl.laser_distance_sensor import Distance, LaserDistanceSensorServant, SensorFault


class Jaws(GripperServant):
    """A gripper that opens by 80 mm. Its handlers make mistakes when they are told to."""

    def __init__(self) -> None:
        self.wrong: Any = None  # called as the handler of `open`, with the Execution

    def base(self) -> Frame:
        return Frame()

    def parent(self) -> str:
        return ""

    def mount(self, on: str, place: Frame) -> None: ...

    def jaws(self) -> GripperState:
        return GripperState()

    def grip_point(self) -> Frame:
        return Frame()

    def max_width(self) -> float:
        return 0.08

    def max_force(self) -> float:
        return 60.0

    def open(self, width: float, run: gecos.Execution[GripperState]) -> None:
        if self.wrong is not None:
            self.wrong(run)
        if width > 0.08:
            raise WidthOutOfRange(width, 0.0, 0.08)

    def close(self, force: float, run: gecos.Execution[GripperState]) -> None: ...


class Laser(LaserDistanceSensorServant):
    """A laser that is switched off."""

    def base(self) -> Frame:
        return Frame()

    def parent(self) -> str:
        return ""

    def mount(self, on: str, place: Frame) -> None: ...

    def beam(self) -> Distance:
        return Distance()

    def measure(self) -> Distance:
        raise SensorFault("the laser is off; call power(True)")

    def power(self, on: bool) -> None: ...
