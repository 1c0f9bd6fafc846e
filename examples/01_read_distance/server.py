"""The paper's first example: a server for a laser distance sensor.

Run `gecos broker` first, then this, then any of the clients beside it.
"""

import math
import time

import gecos
from robcl.device import MountRefused
from robcl.frames import Frame
from robcl.laser_distance_sensor import Distance, LaserDistanceSensorServant, SensorFault


class SwayingWall(LaserDistanceSensorServant):
    """A sensor that looks at a wall which sways: it needs no hardware."""

    def __init__(self) -> None:
        super().__init__()
        self._on = True
        self._base = Frame()

    def measure(self) -> Distance:
        if not self._on:
            raise SensorFault(reason="the laser is off: call power(True)")
        now = time.time()
        distance = Distance(
            value=0.5 + 0.1 * math.sin(now), valid=True, lower=0.05, upper=2.0, stamp=now
        )
        self.publish_beam(distance)
        return distance

    def beam(self) -> Distance:
        return self.measure()

    def power(self, on: bool) -> None:
        self._on = on

    def base(self) -> Frame:
        return self._base

    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None:
        if carrier:
            raise MountRefused(reason=f"this sensor stands on the floor, not on {carrier}")
        self._base = offset


if __name__ == "__main__":
    gecos.serve({"LASER": SwayingWall()}, simulated=True)
