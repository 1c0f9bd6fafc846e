"""Records 250 samples of the tool in a file, each of them once: `stream_record.py FILE`. That is
one second: move the arm meanwhile, by another example."""

import csv
import sys
from pathlib import Path

import gecos
from robcl.manipulator import Manipulator


def main(path: Path) -> None:
    lab = gecos.Lab()
    tool = lab.create(Manipulator, "RX90").tool.stream()  # reading needs no status

    lost = 0
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["sequence", "lost", "stamp", "x", "y", "z"])
        for _ in range(250):
            sample = tool.next(timeout=5.0)  # the next unread one; waits for it
            at = sample.value
            rows.writerow([sample.sequence, sample.lost, sample.stamp, at.x, at.y, at.z])
            lost += sample.lost  # number of samples that a slow reader lost
    print(f"250 samples, {lost} lost")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: stream_record.py FILE")
    main(Path(sys.argv[1]))
