"""Serves DANCER: the Python half of the pairs in test_inward.py."""

from __future__ import annotations

import gecos
import numpy as np
import numpy.typing as npt
from feeder import DancerServant, Step
from words import in_words


class PlainFollower(DancerServant):
    def follow(self, run: gecos.Execution[Step]) -> float:
        """Ends by itself once it has taken a correction whose count is negative."""
        total = 0.0
        with self.alter.feeds(run):
            run.progress(0, Step(x=0.0, count=0))
            while not run.wait_interrupted(0.001):
                while (step := self.alter.next()) is not None:
                    if step.value.count < 0:
                        return total
                    total += step.value.x
                    run.progress(0, step.value)
        raise gecos.Interrupted

    def speeds(self) -> npt.NDArray[np.float64]:
        values = []
        while (sample := self.speed.next()) is not None:
            values.append(sample.value)
        return np.array(values)

    def remarks(self) -> list[str]:
        texts = []
        while (sample := self.remark.next()) is not None:
            texts.append(sample.value.text)
        return texts

    def steps(self) -> npt.NDArray[np.int32]:
        counts = []
        while (sample := self.alter.next()) is not None:
            counts.append(sample.value.count)
        return np.array(counts, dtype=np.int32)

    def told(self, stream: str) -> str:
        return in_words(getattr(self, stream).report())

    def feet(self) -> int:
        return 2


if __name__ == "__main__":
    gecos.serve({"DANCER": PlainFollower()}, simulated=True)
