"""Objects of any type: a list of those online, and proxies with only the built-in operations."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING

from gecos_idl.broker import Broker

import gecos
from gecos.interface import Interface

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry


def entries(lab: gecos.Lab) -> list[Entry]:
    """The entries of the broker, sorted by the name of the object."""
    return sorted(lab.broker(Broker).list().result(), key=lambda entry: entry.name)


def find(lab: gecos.Lab, name: str) -> gecos.Object:
    """A proxy of the object called `name`, whatever its type. Raises CreateError, which proposes a
    similar name or lists the objects online, if there is no such object."""
    known = {entry.name: entry for entry in entries(lab)}
    entry = known.get(name)
    if entry is None:
        reason = f"no such object is online; {_instead_of(name, list(known))}"
        raise gecos.CreateError([gecos.Attempt(name, gecos.Detail.NO_SERVER, reason)])

    itself = Interface(name=entry.interface_name, hash=entry.interface_hash)

    class Anything(gecos.Object):
        _gecos_interface = itself

    return lab.create(Anything, name)


def _instead_of(name: str, known: Sequence[str]) -> str:
    by_lower = {one.lower(): one for one in known}
    near = get_close_matches(name.lower(), by_lower, n=1)
    if near:
        return f"did you mean {by_lower[near[0]]}?"
    return f"the broker knows {', '.join(known) or 'no objects'}"
