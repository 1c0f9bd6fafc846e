"""Serves an object with an open stream: the Python half of the servers in test_open_stream.py."""

from __future__ import annotations

import sys

import gecos
import numpy as np
from barograph import BarographServant, Place, Reading, Trend


def reading(number: int, size: int) -> Reading:
    return Reading(
        number=number,
        place=Place("Königstuhl", 0.862),
        trend=Trend(number % 3),
        pressures=np.arange(size) / 4 + number,
        histogram=np.array([1, 2, 65535], np.uint16),
        remark=None if number % 2 else "calm",
    )


class Barograph(BarographServant):
    def readings(self) -> Reading:
        return reading(0, 0)

    def sealed(self) -> Reading:
        return reading(0, 0)

    def record(self, first: int, times: int, size: int) -> None:
        for number in range(first, first + times):
            self.publish_readings(reading(number, size))
            self.publish_sealed(reading(number, size))


if __name__ == "__main__":
    gecos.serve({sys.argv[1]: Barograph()}, simulated=True, media=sys.argv[2:])
