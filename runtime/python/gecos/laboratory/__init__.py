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

__all__ = [
    "Event",
    "LaboratoryDescription",
    "LaboratoryError",
    "LaboratoryFileError",
    "Program",
    "What",
    "read_laboratory",
    "running",
    "say",
    "show",
    "simulated_laboratory",
]
