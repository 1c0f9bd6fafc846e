"""Serves OVEN: the interface of 07_own_interface, a simulated oven below it."""

import gecos
from oven import OvenServant, TooHot

HOTTEST = 450.0  # K
STEPS = 20


class SimulatedOven(OvenServant):
    def __init__(self) -> None:
        super().__init__()
        self._temperature = 293.0  # K

    def temperature(self) -> float:  # may run while heat() does
        return self._temperature

    def heat(self, to: float, run: gecos.Execution[None]) -> None:
        if to > HOTTEST:
            raise TooHot(limit=HOTTEST)
        start = self._temperature
        for step in range(1, STEPS + 1):
            if run.wait_interrupted(0.05):
                raise gecos.Interrupted()
            self._temperature = start + (to - start) * step / STEPS
            run.progress(step / STEPS)
            self.publish_temperature(self._temperature)


if __name__ == "__main__":
    gecos.serve({"OVEN": SimulatedOven()}, simulated=True)  # until Ctrl-C
