"""Watches the tool while the arm lowers it. The arm publishes 250 samples a second; this program
looks five times a second, and each time gets the newest one."""

import gecos
from robcl.frames import Frame, deg, in_mm, mm, translate
from robcl.manipulator import Manipulator, Trajectory

# Tool frames in the world: z points down, so the second one is 100 mm below the first.
START = Frame.from_euler_zyz(mm(500), mm(200), mm(250), 0.0, deg(180), 0.0)
GOAL = START * translate(0.0, 0.0, mm(100))


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot):
        robot.move(START).result()
        tool = robot.tool.stream()

        slowly = Trajectory(tool_speed=0.08)  # m/s
        move = robot.move(GOAL, slowly)
        while move.wait(0.2) is gecos.State.RUNNING:
            newest = tool.latest()  # never waits; raises StreamLost once the server is lost
            if newest is None:
                continue
            print(
                f"tool at {in_mm(newest.value.z):.1f} mm, {1e3 * newest.age:.2f} ms ago; "
                f"{newest.lost} samples skipped",
                flush=True,
            )
        move.result()


if __name__ == "__main__":
    main()
