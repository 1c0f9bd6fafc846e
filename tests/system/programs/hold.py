"""Holds RX90 and moves it back and forth, slowly, until the move is ended by somebody else."""

import gecos
from robcl.frames import translate
from robcl.manipulator import Manipulator, Trajectory

robot = gecos.Lab().create(Manipulator, "RX90")
lease = gecos.actor(robot)
here = robot.tool().result()
move = robot.move(here * translate(0.0, 0.0, -0.3), Trajectory(speed=0.01))
while move.progress().fraction == 0.0 and move.state is gecos.State.RUNNING:
    pass
print("moving", flush=True)
move.wait()
print(f"ended {move.state.name}/{move.progress().detail.name}", flush=True)
