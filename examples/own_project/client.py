"""Heats OVEN, asks for too much, and says how warm it is."""

import sys

import gecos
from plant.heat import TooHot
from plant.oven import Oven


def main() -> None:
    with gecos.Lab() as lab:
        oven = lab.create(Oven, "OVEN")
        with gecos.actor(oven):  # until its end no other program heats it
            oven.heat(400.0).result()
            try:
                oven.heat(600.0).result()
            except TooHot as too_hot:
                print(f"not above {too_hot.limit:g} K")
            print(f"it is at {oven.temperature().result():g} K")


if __name__ == "__main__":
    try:
        main()
    except (gecos.CreateError, gecos.CommandFailed, gecos.ConnectionFailed) as error:
        sys.exit(str(error))
