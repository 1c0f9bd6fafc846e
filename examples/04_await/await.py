"""An arm and a gripper, each with a sequence of its own. `await` goes on when a command has ended,
so neither sequence needs a thread."""

import asyncio

import gecos
from robcl.frames import mm, translate
from robcl.gripper import Gripper
from robcl.manipulator import Manipulator, Trajectory


async def lift(robot: Manipulator) -> None:
    here = await robot.tool()
    slowly = Trajectory(tool_speed=0.02)  # m/s
    await robot.move(translate(0.0, 0.0, mm(60)) * here, slowly)
    print("arm: lifted", flush=True)


async def exercise(gripper: Gripper) -> None:
    for width_mm in (90, 50):
        await gripper.open(mm(width_mm))
        print(f"gripper: {width_mm} mm", flush=True)


async def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    gripper = lab.create(Gripper, "GRIPPER")
    with gecos.actor(robot), gecos.actor(gripper):
        await asyncio.gather(lift(robot), exercise(gripper))


if __name__ == "__main__":
    asyncio.run(main())
