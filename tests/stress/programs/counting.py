"""Serves DANCER, and prints a line for everything that a client makes it do."""

from __future__ import annotations

import threading
import time

import gecos
import numpy as np
import numpy.typing as npt
from feeder import DancerServant, Step


def tell(what: str) -> None:
    print("did", what, flush=True)


class CountingDancer(DancerServant):
    def follow(self, run: gecos.Execution[Step]) -> float:
        """Ends by itself once it has taken a correction whose count is negative."""
        tell("follow")
        total = 0.0
        with self.alter.feeds(run):
            run.progress(0, Step(x=0.0, count=0))
            while not run.wait_interrupted(0.001):
                while (step := self.alter.next()) is not None:
                    tell(f"alter {step.value.count}")
                    if step.value.count < 0:
                        return total
                    total += step.value.x
                    run.progress(0, step.value)
        raise gecos.Interrupted

    def speeds(self) -> npt.NDArray[np.float64]:
        tell("speeds")
        return np.array([])

    def remarks(self) -> list[str]:
        tell("remarks")
        return []

    def steps(self) -> npt.NDArray[np.int32]:
        tell("steps")
        return np.array([], dtype=np.int32)

    def told(self, stream: str) -> str:
        tell("told")
        return ""

    def feet(self) -> int:
        tell("feet")
        return 2

    def gecos_on_stop(self) -> None:
        tell("stop")


def control(dancer: CountingDancer) -> None:
    """The loop of a device that is moved by samples of a speed."""
    while True:
        while (sample := dancer.speed.next()) is not None:
            tell(f"speed {sample.value:g}")
        while (remark := dancer.remark.next()) is not None:
            tell(f"remark {remark.value.text}")
        time.sleep(0.002)


if __name__ == "__main__":
    dancer = CountingDancer()
    threading.Thread(target=control, args=(dancer,), daemon=True).start()
    gecos.serve({"DANCER": dancer}, simulated=True)
