"""Moves the tool of an arm aside and down, and back. It knows frames and Manipulator alone: the
name of the arm is its only argument."""

import sys

import gecos
from robcl.frames import distance, in_mm, mm, translate
from robcl.manipulator import Manipulator, PathType, Trajectory

robot = gecos.Lab().create(Manipulator, sys.argv[1])
straight = Trajectory(path=PathType.STRAIGHT)
with gecos.actor(robot):
    start = robot.tool().result()
    aside = start * translate(0.0, mm(100), 0.0)
    down = aside * translate(0.0, 0.0, mm(80))
    for goal, how in ((aside, Trajectory()), (down, straight), (aside, straight), (start, None)):
        robot.move(goal, how).result()
        miss = in_mm(distance(robot.tool().result(), goal))
        print(f"{miss:.0f} mm from the goal", flush=True)
