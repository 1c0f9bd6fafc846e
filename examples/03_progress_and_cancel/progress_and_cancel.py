"""Watches a motion while it runs, and cancels it when a third is done."""

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

        slowly = Trajectory(tool_speed=0.02)  # m/s: this motion takes 5 s
        move = robot.move(GOAL, slowly)
        while move.wait(0.2) is gecos.State.RUNNING:
            feedback = move.feedback()  # what this operation reports: a MotionProgress
            if feedback is None:
                continue  # the motion has not begun
            detail = move.progress().detail.name
            print(f"{detail} {feedback.fraction:.0%}, {feedback.remaining:.2f} s left", flush=True)
            if feedback.fraction >= 1 / 3:
                move.cancel()  # a request: the arm brakes, then the move ends

        print(f"{move.state.name}/{move.progress().detail.name}")


if __name__ == "__main__":
    main()
