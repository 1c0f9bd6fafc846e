"""Finds the object that a verb names."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import gecos

BROKER = "BROKER"
"""The name of the broker itself, which no broker lists."""


def find(lab: gecos.Lab, name: str) -> gecos.Object:
    """Connects to the object called `name`, whatever its interface, or to the broker itself. The
    proxy has the built-in operations. Raises like `gecos.dynamic_client.connect.find`."""
    if name == BROKER:
        from gecos_idl.broker import Broker

        return lab.broker(Broker)
    from gecos.dynamic_client import connect

    return connect.find(lab, name)
