"""Bounds how long a motion may take: by a deadline, which ends the motion, or by one's own
patience, which leaves it running."""

import gecos
from robcl.frames import Frame, deg, mm, translate
from robcl.manipulator import Manipulator, Trajectory

# Tool frames in the world: z points down, so the second one is 100 mm below the first.
START = Frame.from_euler_zyz(mm(500), mm(200), mm(250), 0.0, deg(180), 0.0)
GOAL = START * translate(0.0, 0.0, mm(100))


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot):
        robot.move(START).result()
        slowly = Trajectory(tool_speed=0.03)  # m/s: 3.3 s

        for deadline in (0.5, 0.0):  # with 0 the move is not sent
            try:
                gecos.with_deadline(robot, deadline).move(GOAL, slowly).result()
            except gecos.CommandFailed as failed:
                print(f"deadline of {deadline} s: {failed}", flush=True)  # the arm stands

        move = robot.move(GOAL, slowly)
        print(f"patience of 0.5 s: {move.wait(0.5).name}", flush=True)  # the arm moves on
        move.result()
        print(f"in the end: {move.state.name}")


if __name__ == "__main__":
    main()
