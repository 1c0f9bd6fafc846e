"""Lowers the arm, opens the gripper and measures a distance, all at once and in one thread."""

import select

import gecos
from robcl.frames import Frame, deg, mm, translate
from robcl.gripper import Gripper
from robcl.laser_distance_sensor import LaserDistanceSensor
from robcl.manipulator import Manipulator, Trajectory

# Tool frames in the world: z points down, so the second one is 60 mm below the first.
START = Frame.from_euler_zyz(mm(500), mm(200), mm(250), 0.0, deg(180), 0.0)
GOAL = START * translate(0.0, 0.0, mm(60))


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    gripper = lab.create(Gripper, "GRIPPER")
    laser = lab.create(LaserDistanceSensor, "LDS")
    with gecos.actor(robot), gecos.actor(gripper):
        robot.move(START).result()

        lower = robot.move(GOAL, Trajectory(tool_speed=0.03))  # m/s: 2 s
        opening = gripper.open(mm(100))
        look = laser.measure()
        running = {lower: "lower", opening: "open", look: "look"}
        while running:
            ended, _, _ = select.select(running, [], [])  # a command has a descriptor
            for command in ended:
                print(f"{running.pop(command)} has ended", flush=True)
        for command in (lower, opening, look):
            command.result()


if __name__ == "__main__":
    main()
