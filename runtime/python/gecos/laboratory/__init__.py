"""Starts and ends the programs of a laboratory together, for `gecos up`."""

from gecos.laboratory.description import (
    LaboratoryDescription,
    LaboratoryFileError,
    Program,
    read_laboratory,
    simulated_laboratory,
)
from gecos.laboratory.running import LaboratoryError, running

__all__ = [
    "LaboratoryDescription",
    "LaboratoryError",
    "LaboratoryFileError",
    "Program",
    "read_laboratory",
    "running",
    "simulated_laboratory",
]
