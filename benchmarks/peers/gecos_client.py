"""Our client in Python, for the server of gecos_peer.cpp:  gecos_client.py call shm|lcm EXCHANGE"""

from __future__ import annotations

import sys

import gecos
import numpy as np
from exchange import Exchange, Sample
from speaker import speak

PASSWORD = "all clients of one benchmark"


def main() -> None:
    medium, name = sys.argv[2:]
    exchange = gecos.Lab().create(Exchange, name, medium=medium)
    axis = np.zeros(7)

    def call(stamp: float) -> float:
        return exchange.echo(Sample(stamp, axis)).result().stamp

    with gecos.actor(exchange, password=PASSWORD):
        speak(call)


if __name__ == "__main__":
    main()
