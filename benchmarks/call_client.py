"""The client of the sensor call from Python, one end of a pair of call_benchmark.

Reads from standard input for how many seconds to measure, a double; answers on standard output with
the number of round trips and how long each took, doubles of µs; and so on.
"""

import struct
import sys
import time
from array import array

import gecos
from robcl.laser_distance_sensor import LaserDistanceSensor


def main() -> None:
    lab = gecos.Lab()
    laser = lab.create(LaserDistanceSensor, "LASER", medium=sys.argv[1])
    while question := sys.stdin.buffer.read(8):
        (seconds,) = struct.unpack("d", question)
        times = array("d")
        before = time.perf_counter_ns()
        end = before + int(seconds * 1e9)
        while before < end:
            laser.measure().result()
            after = time.perf_counter_ns()
            times.append((after - before) * 1e-3)
            before = after
        sys.stdout.buffer.write(struct.pack("Q", len(times)) + times.tobytes())
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
