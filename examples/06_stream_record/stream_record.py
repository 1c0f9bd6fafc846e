"""Records 50 samples of the distance sensor in a file, each of them once.

Usage: stream_record.py FILE
"""

import csv
import sys
from pathlib import Path

import gecos
from robcl.laser_distance_sensor import LaserDistanceSensor


def main(path: Path) -> None:
    lab = gecos.Lab()
    beam = lab.create(LaserDistanceSensor, "LDS").beam.stream()

    lost = 0
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["sequence", "lost", "stamp", "valid", "distance"])
        for _ in range(50):
            sample = beam.next(timeout=5.0)  # the next unread one; waits for it
            it = sample.value
            rows.writerow([sample.sequence, sample.lost, it.stamp, int(it.valid), it.value])
            lost += sample.lost  # by a reader that is slower than the sensor for too long
    print(f"50 samples, {lost} lost")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: stream_record.py FILE")
    main(Path(sys.argv[1]))
