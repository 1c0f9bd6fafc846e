"""Starts and ends the programs of a laboratory together, for `gecos up`."""

from gecos.laboratory.description import (
    LaboratoryDescription,
    LaboratoryFileError,
    Program,
    read_laboratory,
    simulated_laboratory,
)
from gecos.laboratory.events import Event, What, say, show
from gecos.laboratory.running import LaboratoryError, running
from gecos.laboratory.unread_lists import UnreadLists

__all__ = [
    "Event",
    "LaboratoryDescription",
    "LaboratoryError",
    "LaboratoryFileError",
    "Program",
    "UnreadLists",
    "What",
    "read_laboratory",
    "running",
    "say",
    "show",
    "simulated_laboratory",
]
