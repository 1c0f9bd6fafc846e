"""Bounds how long a motion may take: by a deadline, which ends the motion, or by one's own
patience, which leaves it running."""

import gecos
from robcl.frames import mm, translate
from robcl.manipulator import Manipulator, Trajectory


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot):
        here = robot.tool().result()
        above = translate(0.0, 0.0, mm(100)) * here
        slowly = Trajectory(tool_speed=0.02)  # m/s: 5 s

        for deadline in (1.0, 0.0):  # with 0 the move is not sent
            try:
                gecos.with_deadline(robot, deadline).move(above, slowly).result()
            except gecos.CommandFailed as failed:
                print(f"deadline of {deadline:.0f} s: {failed}", flush=True)  # the arm stands

        move = robot.move(above, slowly)
        print(f"patience of 1 s: {move.wait(1.0).name}", flush=True)  # the arm moves on
        move.result()
        print(f"in the end: {move.state.name}")


if __name__ == "__main__":
    main()
