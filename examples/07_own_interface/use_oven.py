"""Uses an interface of one's own: oven.gidl beside this file. Needs 08_serve, which serves OVEN.

`gidl gen --lang python --out generated oven.gidl` makes `generated/python/oven.py` for it.
"""

import gecos
from oven import Oven, TooHot


def main() -> None:
    lab = gecos.Lab()
    oven = lab.create(Oven, "OVEN")
    with gecos.actor(oven):
        try:
            oven.heat(600.0).result()  # outside its @range: is not sent
        except ValueError as error:
            print(f"600 K: {error}")

        try:
            oven.heat(480.0).result()
        except TooHot as too_hot:  # declared by the interface
            print(f"480 K: this oven goes up to {too_hot.limit:.0f} K")

        oven.heat(350.0).result()
        print(f"350 K: the oven is at {oven.temperature().result():.0f} K")


if __name__ == "__main__":
    main()
