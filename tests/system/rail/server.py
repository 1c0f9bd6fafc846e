"""Serves RAIL: the Python half of the pairs in test_pairs.py."""

import math
import time

import gecos
from lab.rail_sensor import RailEnd, RailSensorServant
from robcl.device import MountRefused
from robcl.frames import Frame, translate
from robcl.laser_distance_sensor import Distance, SensorFault

WALL = 2.0
RAIL_END = 1.0
SPEED = 0.5
TICK = 0.02


class Rail(RailSensorServant):
    def __init__(self) -> None:
        super().__init__()
        self._position = 0.0
        self._on = True

    def travel(self, target: float, run: gecos.Execution[None]) -> None:
        if not 0 <= target <= RAIL_END:
            raise RailEnd(limit=RAIL_END)
        start, began = self._position, time.monotonic()
        way = abs(target - start)
        while self._position != target:
            if run.wait_interrupted(TICK):
                raise gecos.Interrupted
            step = min(SPEED * (time.monotonic() - began), way)
            self._position = start + math.copysign(step, target - start)
            run.progress(step / way)
            self.publish_beam(self.beam())

    def measure(self) -> Distance:
        if not self._on:
            raise SensorFault(reason="the laser is off")
        return self.beam()

    def beam(self) -> Distance:
        return Distance(
            value=WALL - self._position, valid=True, lower=0.05, upper=2.5, stamp=time.time()
        )

    def power(self, on: bool) -> None:
        self._on = on

    def base(self) -> Frame:
        return translate(self._position, 0.0, 0.0)

    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None:
        raise MountRefused(reason="it is bolted to its rail")


if __name__ == "__main__":
    gecos.serve({"RAIL": Rail()}, simulated=True)
