"""Holds RX90 and turns its first joint, slowly, until the move is ended by somebody else."""

import gecos
from robcl.manipulator import Trajectory
from robcl.six_axis import Joints, SixAxis

robot = gecos.Lab().create(SixAxis, "RX90")
lease = gecos.actor(robot)
there = robot.joints().result().position.copy()
there[0] += 1.0
move = robot.move_joints(Joints(position=there), Trajectory(speed=0.02))
while move.wait(0.01) is gecos.State.RUNNING and move.progress().fraction == 0.0:
    pass
print(f"moving {move!r}", flush=True)
move.wait()
print(f"ended {move.state.name}/{move.progress().detail.name}: {move.exception()}", flush=True)
