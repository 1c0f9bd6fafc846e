"""Lifts the arm, opens the gripper and measures a distance, all at once and in one thread."""

import select

import gecos
from robcl.frames import mm, translate
from robcl.gripper import Gripper
from robcl.laser_distance_sensor import LaserDistanceSensor
from robcl.manipulator import Manipulator, Trajectory


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    gripper = lab.create(Gripper, "GRIPPER")
    laser = lab.create(LaserDistanceSensor, "LDS")
    with gecos.actor(robot), gecos.actor(gripper):
        here = robot.tool().result()

        lift = robot.move(translate(0.0, 0.0, mm(60)) * here, Trajectory(tool_speed=0.02))
        opening = gripper.open(mm(100))
        look = laser.measure()
        running = {lift: "lift", opening: "open", look: "look"}
        while running:
            ended, _, _ = select.select(running, [], [])  # a command has a descriptor
            for command in ended:
                print(f"{running.pop(command)} has ended", flush=True)
        for command in (lift, opening, look):
            command.result()


if __name__ == "__main__":
    main()
