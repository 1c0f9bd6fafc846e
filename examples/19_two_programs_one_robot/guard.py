"""Watches the distance sensor on the flange of a robot that another program moves. When something
is closer than 200 mm, takes over, retreats by 100 mm, and gives the robot back.

To mount the sensor there:

    gecos call LDS mount '{"carrier": "RX90", "offset": {"orientation": {"w": 1}}}'
"""

import sys

import gecos
from robcl.frames import mm, translate
from robcl.laser_distance_sensor import LaserDistanceSensor
from robcl.manipulator import Manipulator


def main(password: str) -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    laser = lab.create(LaserDistanceSensor, "LDS")
    with gecos.actor(robot, password):
        print("watching the distance", flush=True)
        for sample in laser.beam.stream():
            if sample.value.valid and sample.value.value < mm(200):
                break

        gecos.take_over(robot).result()  # the other program's motion ends
        print(f"taken over at {sample.value.value * 1000:.0f} mm", flush=True)
        robot.move(translate(0.0, 0.0, mm(100)) * robot.tool().result()).result()
        input()  # until someone has looked, and presses Return
        gecos.give_back(robot).result()
        print(f"given back at {laser.measure().result().value * 1000:.0f} mm")


if __name__ == "__main__":
    try:
        main(sys.argv[1] if len(sys.argv) > 1 else "")
    except (gecos.LeaseRefused, gecos.CommandFailed, ConnectionError) as failed:
        sys.exit(str(failed))
