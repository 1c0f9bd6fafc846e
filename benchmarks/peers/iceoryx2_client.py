"""iceoryx2's client in Python, polling, for the server of iceoryx2/src/main.rs:
iceoryx2_client.py call poll NAME
iceoryx2_client.py call images-poll NAME"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable

import iceoryx2 as iox2
import image_speaker
import numpy as np
from speaker import speak


class Sample(ctypes.Structure):
    _fields_ = (("stamp", ctypes.c_double), ("axis", ctypes.c_double * 7))

    @staticmethod
    def type_name() -> str:
        return "Sample"  # as the server calls it


class Image(ctypes.Structure):
    _fields_ = (("stamps", ctypes.c_int64 * 4), ("octets", ctypes.c_uint8 * (1920 * 1080 * 3 - 32)))

    @staticmethod
    def type_name() -> str:
        return "Image"


def main() -> None:
    how, name = sys.argv[2:]
    iox2.set_log_level(iox2.LogLevel.Error)
    node = iox2.NodeBuilder.new().create(iox2.ServiceType.Ipc)
    service = node.service_builder(iox2.ServiceName.new(name))
    read_images(service) if how == "images-poll" else make_calls(service)


def read_images(builder: iox2.ServiceBuilder) -> None:
    service = builder.publish_subscribe(Image).subscriber_max_buffer_size(1).open()
    subscriber = service.subscriber_builder().create()
    held = None

    def next_image() -> tuple[image_speaker.Octets, Callable[[], bool]]:
        nonlocal held
        if held is not None:
            held.delete()
        while (held := subscriber.receive()) is None:
            pass
        octets = ctypes.cast(held.payload(), ctypes.POINTER(ctypes.c_uint8))
        return np.ctypeslib.as_array(octets, (1920 * 1080 * 3,)), lambda: True

    image_speaker.speak(next_image)


def make_calls(builder: iox2.ServiceBuilder) -> None:
    service = builder.request_response(Sample, Sample).max_active_requests_per_client(64).open()
    client = service.client_builder().create()

    def call(stamp: float) -> float:
        pending = client.loan_uninit().write_payload(Sample(stamp=stamp)).send()
        while True:
            response = pending.receive()
            if response is not None:
                answered: float = response.payload().contents.stamp
                response.delete()
                pending.delete()
                return answered

    speak(call)


if __name__ == "__main__":
    main()
