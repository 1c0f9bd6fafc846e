"""Two of these at two terminals move one robot together: each `up` or `down` that is typed moves
it by 20 mm. The first one sets the password, the next one joins by it:
`share_by_password.py "two hands"`.
"""

import sys

import gecos
from robcl.frames import mm, translate
from robcl.manipulator import Manipulator


def main(password: str) -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot, password=password):
        print("programs that may move RX90:", len(gecos.holders(robot).result()), flush=True)

        for line in sys.stdin:
            here = robot.tool().result()
            dz = mm(20) if line.strip() == "up" else -mm(20)
            robot.move(translate(0.0, 0.0, dz) * here).result()
            print(f"{line.strip()}: done", flush=True)


if __name__ == "__main__":
    try:
        main(sys.argv[1] if len(sys.argv) > 1 else "")
    except gecos.LeaseRefused as refused:  # with another password: says who holds the robot
        sys.exit(str(refused))
