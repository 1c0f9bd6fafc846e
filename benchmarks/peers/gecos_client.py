"""Our client in Python, for the server of gecos_peer.cpp:  gecos_client.py call shm|lcm EXCHANGE
gecos_client.py call images-poll CAMERA"""

from __future__ import annotations

import sys
from collections.abc import Callable

import gecos
import image_speaker
import numpy as np
from exchange import Camera, Exchange, Sample
from speaker import speak

PASSWORD = "all clients of one benchmark"


def main() -> None:
    how, name = sys.argv[2:]
    if how == "images-poll":
        read_images(name)
    else:
        make_calls(how, name)


def read_images(name: str) -> None:
    stream = gecos.Lab().create(Camera, name, medium="shm").picture.stream()
    read = 0

    def next_image() -> tuple[image_speaker.Octets, Callable[[], bool]]:
        nonlocal read
        while (sample := stream.latest_in_place()) is None or sample.sequence == read:
            pass
        read = sample.sequence
        return np.asarray(sample.octets), sample.intact

    image_speaker.speak(next_image)


def make_calls(medium: str, name: str) -> None:
    exchange = gecos.Lab().create(Exchange, name, medium=medium)
    axis = np.zeros(7)

    def call(stamp: float) -> float:
        return exchange.echo(Sample(stamp, axis)).result().stamp

    with gecos.actor(exchange, password=PASSWORD):
        speak(call)


if __name__ == "__main__":
    main()
