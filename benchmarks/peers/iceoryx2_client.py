"""iceoryx2's client in Python, polling, for the server of iceoryx2/src/main.rs:
iceoryx2_client.py call poll NAME"""

from __future__ import annotations

import ctypes
import sys

import iceoryx2 as iox2
from speaker import speak


class Sample(ctypes.Structure):
    _fields_ = (("stamp", ctypes.c_double), ("axis", ctypes.c_double * 7))

    @staticmethod
    def type_name() -> str:
        return "Sample"  # as the server calls it


def main() -> None:
    iox2.set_log_level(iox2.LogLevel.Error)
    node = iox2.NodeBuilder.new().create(iox2.ServiceType.Ipc)
    service = (
        node.service_builder(iox2.ServiceName.new(sys.argv[3]))
        .request_response(Sample, Sample)
        .max_active_requests_per_client(64)
        .open()
    )
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
