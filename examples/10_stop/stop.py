"""Stops a robot that another program moves. Stopping needs no status: `gecos stop RX90` at a
terminal does the same."""

import gecos
from robcl.frames import Frame, deg, mm, translate
from robcl.manipulator import Manipulator, MotionProgress, Trajectory

# Tool frames in the world: z points down, so the second one is 100 mm below the first.
START = Frame.from_euler_zyz(mm(500), mm(200), mm(250), 0.0, deg(180), 0.0)
GOAL = START * translate(0.0, 0.0, mm(100))


def tell(what: str, command: gecos.Command[None, MotionProgress]) -> None:
    """Waits for its end, and says how it ended."""
    command.wait()
    print(f"{what}: {command.exception() or command.state.name}", flush=True)


def main() -> None:
    robot = gecos.Lab().create(Manipulator, "RX90")
    with gecos.actor(robot):
        robot.move(START).result()
        slowly = Trajectory(tool_speed=0.02)  # m/s
        move = robot.move(GOAL, slowly)
        while move.progress().fraction < 0.1 and move.wait(0.05) is gecos.State.RUNNING:
            pass

        # A session of its own, as another program has; it holds no status.
        same_robot = gecos.Lab().create(Manipulator, "RX90")
        gecos.stop(same_robot).result()

        tell("the move", move)
        tell("the next", robot.move(START))  # the stop has ended the lease, too
    with gecos.actor(robot):  # acquire it again when the robot may move again
        tell("with a new lease", robot.move(START))


if __name__ == "__main__":
    main()
