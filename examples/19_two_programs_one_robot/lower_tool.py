"""Lowers the tool towards the block, under a status that programs share which know the password.
When `guard` takes over, the motion ends, and this program waits until it may command again. Where
the robot is in a zone, the motion also ends when nobody is present any more (`hold_button`).
"""

import sys

import gecos
from robcl.frames import Frame, deg, mm, translate
from robcl.manipulator import Manipulator, Trajectory

START = Frame.from_euler_zyz(mm(500), mm(200), mm(300), 0.0, deg(180), 0.0)  # z points down


def main(password: str) -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot, password):  # without the password: is refused and told who holds it
        robot.move(START).result()
        print("lowering the tool", flush=True)
        try:
            robot.move(START * translate(0.0, 0.0, mm(200)), Trajectory(tool_speed=0.05)).result()
        except gecos.CommandFailed as failed:
            print(failed, flush=True)
        try:
            robot.move(START).result()
        except gecos.CommandFailed as held_off:
            print(held_off, flush=True)
        told = gecos.roster(robot).result()
        while any(holder.taken_over for holder in told.holders):
            told = gecos.roster(robot, told.newest, timeout=None).result()  # waits for a change
        robot.move(START).result()  # nothing resumes by itself: this is a new command
        print("at the start again")


if __name__ == "__main__":
    try:
        main(sys.argv[1] if len(sys.argv) > 1 else "")
    except (gecos.LeaseRefused, gecos.CommandFailed, ConnectionError) as failed:
        sys.exit(str(failed))
