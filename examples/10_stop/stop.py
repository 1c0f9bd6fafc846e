"""Stops a robot that another program moves. Stopping needs no status: `gecos stop RX90` at a
terminal does the same."""

import gecos
from robcl.frames import mm, translate
from robcl.manipulator import Manipulator, Trajectory


def main() -> None:
    robot = gecos.Lab().create(Manipulator, "RX90")
    with gecos.actor(robot):
        here = robot.tool().result()
        slowly = Trajectory(tool_speed=0.02)  # m/s
        move = robot.move(translate(0.0, 0.0, mm(100)) * here, slowly)
        while move.progress().fraction < 0.1 and move.wait(0.05) is gecos.State.RUNNING:
            pass

        # A session of its own, as another program has; it holds no status.
        same_robot = gecos.Lab().create(Manipulator, "RX90")
        gecos.stop(same_robot).result()

        move.wait()
        print("the move:", move.exception())
        denied = robot.move(here)  # the lease is over
        denied.wait()
        print("the next:", denied.exception())

    with gecos.actor(robot):  # who knows that the robot may move again acquires it anew
        robot.move(here).result()
        print("with a new lease: moved")


if __name__ == "__main__":
    main()
