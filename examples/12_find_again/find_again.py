"""Reads a sensor for ever, whenever its server is there: start, end and kill `robcl-lds` as you
like. Ctrl-C ends it."""

import time

import gecos
from robcl.laser_distance_sensor import LaserDistanceSensor


def read_from(laser: LaserDistanceSensor) -> None:
    """Reads until the server is lost."""
    beam = laser.beam.stream()
    print(f"found: {beam.next().value.value} m", flush=True)
    for _ in beam:
        pass


def main() -> None:
    lab = gecos.Lab()
    while True:  # a proxy whose server is gone stays dead: create a new one
        try:
            read_from(lab.create(LaserDistanceSensor, "LDS"))
        except (gecos.StreamLost, gecos.ConnectionFailed, gecos.CommandFailed):
            print("lost", flush=True)
        except gecos.CreateError as error:
            print(f"not found: {error}", flush=True)
            time.sleep(0.5)  # before the next try


if __name__ == "__main__":
    main()
