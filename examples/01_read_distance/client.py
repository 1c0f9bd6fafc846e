"""Reads the laser distance sensor once. `client.py shm` or `client.py lcm` names the medium."""

import sys

import gecos
from robcl.laser_distance_sensor import LaserDistanceSensor


def main() -> None:
    lab = gecos.Lab()
    medium = sys.argv[1] if len(sys.argv) > 1 else None
    laser = lab.create(LaserDistanceSensor, "LASER", medium=medium)
    command = laser.measure()  # on its way; this program could do something else now
    distance = command.result()  # wait for it
    print(f"{distance.value:.3f} m" if distance.valid else "nothing within reach")


if __name__ == "__main__":
    try:
        main()
    except (gecos.CreateError, gecos.CommandFailed, gecos.ConnectionFailed) as error:
        sys.exit(str(error))
