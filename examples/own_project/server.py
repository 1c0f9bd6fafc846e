"""Serves OVEN until Ctrl-C. Run `gecos broker` first."""

import gecos
from plant.heat import TooHot
from plant.oven import OvenServant
from robcl.device import MountRefused
from robcl.frames import Frame

LIMIT_K = 500.0


class Oven(OvenServant):
    """An oven that has its set temperature at once."""

    def __init__(self) -> None:
        super().__init__()
        self._temperature = 293.0  # K
        self._base = Frame()

    def temperature(self) -> float:
        return self._temperature

    def heat(self, to: float) -> None:
        if to > LIMIT_K:
            raise TooHot(limit=LIMIT_K)
        self._temperature = to

    def base(self) -> Frame:
        return self._base

    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None:
        if carrier:
            raise MountRefused(reason="an oven stands on the floor")
        self._base = offset


if __name__ == "__main__":
    gecos.serve({"OVEN": Oven()}, simulated=True)
