"""Objects of any type: what is online, and a proxy that has only what every object answers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gecos_idl.broker import Broker

import gecos
from gecos.interface import Interface

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry


def entries(lab: gecos.Lab) -> list[Entry]:
    """What the broker knows, by name."""
    return sorted(lab.broker(Broker).list().result(), key=lambda entry: entry.name)


def find(lab: gecos.Lab, name: str) -> gecos.Object:
    """The object of that name, whatever its type. Raises CreateError that names what is online."""
    known = {entry.name: entry for entry in entries(lab)}
    entry = known.get(name)
    if entry is None:
        online = ", ".join(known) or "nothing"
        reason = f"no such object is online; the broker knows {online}"
        raise gecos.CreateError([gecos.Attempt(name, gecos.Detail.NO_SERVER, reason)])

    itself = Interface(name=entry.interface_name, hash=entry.interface_hash)

    class Anything(gecos.Object):
        _gecos_interface = itself

    return lab.create(Anything, name)
