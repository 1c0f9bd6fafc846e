"""Drives a cart by a stream of speeds, and stops sending. Needs serve_cart, which serves CART."""

import gecos
from cart import Cart


def main() -> None:
    lab = gecos.Lab()
    cart = lab.create(Cart, "CART")
    with gecos.actor(cart):
        speed = cart.speed.writer()
        try:
            speed.send(3.0)  # outside its @range: is not sent
        except ValueError as error:
            print(f"3 m/s: {error}")

        drive = cart.drive()
        speed.feeds(drive)  # its samples have no effect on another command
        for step in range(50):
            speed.send(0.01 * step)  # m/s; has no effect after a stop
            drive.wait(0.02)
        # Nothing more is sent, as if this program hung: the cart stands by itself.
        print(f"driven to {drive.result():.2f} m")
        report = speed.report().result()
        print(
            f"{report.admitted} of 50 speeds were used, {report.lost} were replaced by newer ones"
        )


if __name__ == "__main__":
    main()
