"""Moves the tool of BENCH 100 mm aside. It knows Manipulator alone, as a program for any arm."""

import sys

import gecos
from robcl.frames import mm, translate
from robcl.manipulator import Manipulator


def main() -> None:
    with gecos.Lab() as lab:
        arm = lab.create(Manipulator, "BENCH")
        with gecos.actor(arm):  # until its end no other program moves it
            arm.move(arm.tool().result() * translate(0.0, mm(100), 0.0)).result()
    print("the tool is 100 mm aside")


if __name__ == "__main__":
    try:
        main()
    except (gecos.CreateError, gecos.CommandFailed, gecos.ConnectionFailed) as error:
        sys.exit(str(error))
