"""What the doctor says about one thing."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Level(StrEnum):
    OK = "ok"
    WARNING = "warning"  # matters for some uses only, as real time or a second host
    ERROR = "error"  # must be corrected


@dataclass(frozen=True, slots=True)
class Finding:
    """`where`: file, folder, variable or address. `mend`: the command or the setting that mends it;
    empty when nothing is wrong."""

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
