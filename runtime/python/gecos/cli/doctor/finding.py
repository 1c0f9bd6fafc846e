"""The result of one check of `gecos doctor`."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Level(StrEnum):
    OK = "ok"
    WARNING = "warning"  # matters only for some uses, for example real time or a second host
    ERROR = "error"  # must be corrected


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of one check. `where` is a file, folder, variable or address. `mend` is the
    command or the setting that corrects the problem; it is empty if nothing is wrong."""

    check: str
    level: Level
    what: str
    where: str = ""
    mend: str = ""


def fine(check: str, what: str, where: str = "") -> Finding:
    return Finding(check, Level.OK, what, where)


def warning(check: str, what: str, where: str, mend: str) -> Finding:
    return Finding(check, Level.WARNING, what, where, mend)


def wrong(check: str, what: str, where: str, mend: str) -> Finding:
    return Finding(check, Level.ERROR, what, where, mend)
