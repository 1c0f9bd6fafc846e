"""Drives a cart until its server says that it has bumped. Needs 14's serve_cart."""

import gecos
from cart import Cart


def main() -> None:
    lab = gecos.Lab()
    cart = lab.create(Cart, "CART")
    with gecos.actor(cart), cart.bumped.stream() as bumped:  # hears all events from now on
        for towards in (0.5, -0.5):  # m/s
            speed, drive = cart.speed.writer(), cart.drive()
            speed.feeds(drive)
            while drive.wait(0.02) is gecos.State.RUNNING:
                speed.send(towards)
            drive.result()
            event = bumped.next(1.0)  # s; raises TimeoutError if none comes
            print(f"bumped at {event.value.at:+.1f} m; {event.lost} bumps were missed")


if __name__ == "__main__":
    main()
