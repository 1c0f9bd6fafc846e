"""A device for tests that need one, whatever it is."""

from __future__ import annotations

from robcl.device import DeviceServant
from robcl.frames import Frame


class Shelf(DeviceServant):
    """A device that stays where it is."""

    def base(self) -> Frame:
        return Frame()

    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None:
        pass
