"""The hand-over of the paper (Fig. 4): robot A gives a block to robot B in the air, and takes it
back."""

import sys

import gecos
from robcl.frames import Frame, deg, distance, mm, translate
from robcl.gripper import Gripper
from robcl.manipulator import Manipulator, PathType, Trajectory
from robcl.world import World

# Where the robots stand, in the world: they face each other.
BASE_A = Frame()
BASE_B = Frame.from_euler_zyz(mm(1500), 0.0, 0.0, deg(180), 0.0, 0.0)

# Tool frames. A tool approaches along its z axis. T, where the block is handed over, is A's: its
# z axis points to B. B's is T * D: the same place, face to face.
BLOCK = Frame.from_euler_zyz(mm(500), mm(200), mm(50), 0.0, deg(180), 0.0)
T = Frame.from_euler_zyz(mm(750), 0.0, mm(600), 0.0, deg(90), 0.0)
D = Frame.from_euler_zyz(0.0, 0.0, 0.0, 0.0, deg(180), 0.0)

STRAIGHT = Trajectory(speed=0.5, path=PathType.STRAIGHT)


class Robot:
    """An arm with its gripper."""

    def __init__(self, lab: gecos.Lab, name: str) -> None:
        self.name = name
        self.arm = lab.create(Manipulator, name)
        self.gripper = lab.create(Gripper, f"GRIPPER_{name}")

    def approach(self, tool: Frame) -> None:
        """Moves to a place 150 mm in front of `tool`, then straight to `tool`."""
        self.arm.move(tool * translate(0.0, 0.0, -mm(150))).result()
        self.arm.move(tool, STRAIGHT).result()

    def retreat(self, tool: Frame) -> None:
        self.arm.move(tool * translate(0.0, 0.0, -mm(150)), STRAIGHT).result()

    def grip(self) -> None:
        self.gripper.close(30.0).result()

    def release(self) -> None:
        self.gripper.open(mm(100)).result()


def hand_over(giver: Robot, taker: Robot, world: World, meeting: Frame) -> None:
    """Both arms are at the block, `giver` holds it."""
    before = world.find("BLOCK").result().pose
    taker.grip()
    both = world.find("BLOCK").result().holders
    giver.release()
    block = world.find("BLOCK").result()
    moved = distance(before, block.pose) * 1000
    print(f"{' and '.join(both)} held it, now {' and '.join(block.holders)};", end=" ")
    print(f"the block has moved by {moved:.2f} mm", flush=True)
    giver.retreat(meeting)


def main() -> None:
    lab = gecos.Lab()
    world = lab.create(World, "WORLD")
    a, b = Robot(lab, "A"), Robot(lab, "B")
    with gecos.actor(a.arm), gecos.actor(a.gripper), gecos.actor(b.arm), gecos.actor(b.gripper):
        a.arm.mount("", BASE_A).result()
        b.arm.mount("", BASE_B).result()
        a.release()
        b.release()

        a.approach(BLOCK)
        a.grip()
        a.retreat(BLOCK)

        a.arm.move(T).result()
        b.approach(T * D)
        hand_over(a, b, world, T)

        a.approach(T)
        hand_over(b, a, world, T * D)

        a.retreat(T)
        a.approach(BLOCK)
        a.release()
        a.retreat(BLOCK)
        print("A has put the block back")


if __name__ == "__main__":
    try:
        main()
    except (
        gecos.CreateError,
        gecos.CommandFailed,
        gecos.ConnectionFailed,
        gecos.LeaseRefused,
    ) as error:
        sys.exit(str(error))
