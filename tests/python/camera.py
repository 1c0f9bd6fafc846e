"""An interface by hand whose values are as large as images:

@sensor sequence<octet> develop(in sequence<octet> film);
"""

from __future__ import annotations

from typing import ClassVar

import gecos
from gecos.interface import Access, Handler, Interface, Method, Operation
from gecos.wire import MAX_COUNT, Decoder, Parts, octets


def _octets(source: Decoder) -> bytes:
    return source.octets(source.count(1))


def _octets_argument(source: Decoder) -> tuple[bytes]:
    return (_octets(source),)


def _octets_parts(value: bytes) -> Parts:
    return octets(value, MAX_COUNT)


DEVELOP = Method[bytes, None](Operation(code=0x2001, name="develop", access=Access.SENSOR), _octets)
CAMERA = Interface(name="test::Camera", version="1.0", operations=(DEVELOP.operation,))


class Camera(gecos.Object):
    _gecos_interface = CAMERA

    def develop(self, film: bytes) -> gecos.Command[bytes]:
        return self._gecos_call(DEVELOP, _octets_parts(film))


class InvertingCamera(gecos.Servant):
    """Gives back what it got, each byte turned over."""

    _gecos_interface = CAMERA
    _gecos_handlers: ClassVar[dict[int, Handler]] = {
        0x2001: Handler(DEVELOP.operation, "develop", _octets_argument, _octets_parts),
    }

    def develop(self, film: bytes) -> bytes:
        return inverted(film)


def inverted(film: bytes) -> bytes:
    return film.translate(bytes(range(255, -1, -1)))
