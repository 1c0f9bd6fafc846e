"""Serves CART, a simulated cart that is driven by a stream of speeds: for 14 and 15."""

import gecos
from cart import Cart_bumped, CartServant

END = 0.5  # m, of the rail in both directions
CYCLE = 0.02  # s


class SimulatedCart(CartServant):
    def __init__(self) -> None:
        super().__init__()
        self._position = 0.0  # m

    def drive(self, run: gecos.Execution[None]) -> float:
        speed = 0.0
        with self.speed.feeds(run):  # from now on, only speeds that feed this command count
            while not run.wait_interrupted(CYCLE):
                if newer := self.speed.newest():
                    speed = newer.value
                if self.speed.expired:  # the client may have hung: stand
                    return self._position
                self._position += speed * CYCLE
                if abs(self._position) > END:
                    self._position = END if speed > 0 else -END
                    self.publish_bumped(Cart_bumped(at=self._position))
                    return self._position
        raise gecos.Interrupted()


if __name__ == "__main__":
    gecos.serve({"CART": SimulatedCart()}, simulated=True)  # until Ctrl-C
