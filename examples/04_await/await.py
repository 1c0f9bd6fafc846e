"""An arm and a gripper, each with a sequence of its own. `await` goes on when a command has ended,
so neither sequence needs a thread."""

import asyncio

import gecos
from robcl.frames import Frame, deg, mm, translate
from robcl.gripper import Gripper
from robcl.manipulator import Manipulator, Trajectory

# Tool frames in the world: z points down, so the second one is 60 mm below the first.
START = Frame.from_euler_zyz(mm(500), mm(200), mm(250), 0.0, deg(180), 0.0)
GOAL = START * translate(0.0, 0.0, mm(60))


async def lower(robot: Manipulator) -> None:
    await robot.move(START)
    print("arm: at its start", flush=True)
    await robot.move(GOAL, Trajectory(tool_speed=0.03))  # m/s: 2 s
    print("arm: lowered", flush=True)


async def exercise(gripper: Gripper) -> None:
    for width_mm in (90, 50):
        await gripper.open(mm(width_mm))
        print(f"gripper: {width_mm} mm", flush=True)


async def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    gripper = lab.create(Gripper, "GRIPPER")
    with gecos.actor(robot), gecos.actor(gripper):
        await asyncio.gather(lower(robot), exercise(gripper))


if __name__ == "__main__":
    asyncio.run(main())
