"""The description of a laboratory in `lab.toml`: its broker, its programs, and whom it admits."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gecos import _core

CLOCK_VARIABLE = "ROBCL_CLOCK"
"""The environment variable from which simulated devices read the speed of the lab clock."""
_SLOWEST_CLOCK, _FASTEST_CLOCK = 0.1, 100_000.0
_FOR_PROGRAMS = ("admin", "allow", "media", "names", "objects", "streams")


class LaboratoryFileError(ValueError):
    """`lab.toml` cannot be read, or has a wrong entry. The text begins with file and line."""


@dataclass(frozen=True, slots=True)
class Program:
    """A program of the laboratory."""

    name: str  # the name for people, for example "RX90"
    run: tuple[str, ...]  # the program and its arguments
    restart: bool = False  # True: start it again when it ends by itself
    # The program is ready when it has printed a line that contains this text. "": the program is
    # ready at once. None: the program is ready when it has printed a line that servers usually
    # print, for example "serving RX90".
    ready: str | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    line: int = 0  # line in lab.toml; 0 if there is no file


@dataclass(frozen=True, slots=True)
class LaboratoryDescription:
    programs: tuple[Program, ...]  # in the order in which they start
    starts_broker: bool = True
    broker_address: str = ""  # where programs look for the broker; "": on this host
    folder: Path = Path()  # relative paths of programs are relative to this folder
    file: str = ""  # for example "lab.toml"; "" if there is no file
    # The tables of the file that servers and clients read, for example ("allow", "media"). If there
    # are any, the programs must read the file.
    tables_for_programs: tuple[str, ...] = ()
    # Simulated seconds that pass in a second. None: the value of ROBCL_CLOCK, or real time without
    # that variable.
    clock_speed: float | None = None


def simulated_laboratory() -> LaboratoryDescription:
    """Returns the simulated devices of robcl: world, arm, gripper and laser distance sensor."""
    programs = {
        "WORLD": "robcl-world",
        "RX90": "robcl-rx90",
        "GRIPPER": "robcl-gripper",
        "LDS": "robcl-lds",
    }
    return LaboratoryDescription(tuple(Program(name, (run,)) for name, run in programs.items()))


def read_laboratory(path: Path) -> LaboratoryDescription:
    """Reads a laboratory from `lab.toml`. Raises LaboratoryFileError."""
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except OSError as error:
        raise LaboratoryFileError(f"{path}: {error.strerror}") from None
    except ValueError as error:  # not UTF-8, or not TOML; then the error has line and column
        raise LaboratoryFileError(f"{path}: {error}") from None
    # Servers and clients read the same file. The function that they use checks the keys, the lists
    # of users, the media and the address of the broker; _Reader checks the rest.
    if problem := _core.lab_file_problem(text, str(path)):
        raise LaboratoryFileError(problem)
    return _Reader(path, text).laboratory(data)


class _Reader:
    def __init__(self, path: Path, text: str) -> None:
        self._path = path
        self._lines = text.splitlines()

    def laboratory(self, data: dict[str, Any]) -> LaboratoryDescription:
        broker = data.get("broker", {})
        address = broker.get("address", "")
        clock_speed = self._clock_speed(data["clock"]) if "clock" in data else None
        programs = data.get("programs", {})
        if not programs:
            self._refuse("programs", "no program is named; add [programs.NAME] with run = […]")
        return LaboratoryDescription(
            tuple(self._program(programs, name) for name in programs),
            broker.get("start", not address),
            address,
            self._path.resolve().parent,
            str(self._path),
            tuple(table for table in _FOR_PROGRAMS if table in data),
            clock_speed,
        )

    def _clock_speed(self, table: dict[str, Any]) -> float:
        speed: Any = table.get("speed", 0)
        number = isinstance(speed, int | float) and not isinstance(speed, bool)
        if not number or not _SLOWEST_CLOCK <= speed <= _FASTEST_CLOCK:
            self._refuse(
                "clock.speed",
                f"a number from {_SLOWEST_CLOCK:g} to {_FASTEST_CLOCK:g} is expected: the "
                "simulated seconds that pass in a second",
            )
        return float(speed)

    def _program(self, programs: dict[str, Any], name: str) -> Program:
        place = f"programs.{name}"
        if name == "BROKER":
            self._refuse(place, "this is the name of the broker; give the program another one")
        table = programs[name]
        run = self._value(table, place, "run", list, "a list of words", [])
        if not run or not all(isinstance(word, str) for word in run) or not run[0]:
            self._refuse(
                f"{place}.run", 'write a list of texts, for example ["robcl-rx90", "--name", "A"]'
            )
        environment = self._value(table, place, "environment", dict, "a table", {})
        if not all(isinstance(value, str) for value in environment.values()):
            self._refuse(
                f"{place}.environment",
                'the values must be texts, for example { GECOS_LCM_TTL = "0" }',
            )
        return Program(
            name,
            tuple(run),
            self._value(table, place, "restart", bool, "true or false", False),
            self._value(table, place, "ready", str, "a text", "") if "ready" in table else None,
            environment,
            self._line(place),
        )

    def _value(
        self, table: dict[str, Any], place: str, key: str, kind: type, wanted: str, otherwise: Any
    ) -> Any:
        value = table.get(key, otherwise)
        if not isinstance(value, kind):
            self._refuse(f"{place}.{key}", f"{wanted} is expected")
        return value

    def _refuse(self, place: str, why: str) -> None:
        raise LaboratoryFileError(f"{self._path}:{self._line(place)}: {place}: {why}")

    def _line(self, place: str) -> int:
        """Returns the line of a key, or of the header of a table, counted from 1. If the key is
        written in another form, for example as a dotted key, returns the line of the innermost
        table around it."""
        place = _bare(place)
        table, best, best_size = "", 1, 0
        for number, line in enumerate(self._lines, 1):
            header = re.match(r"\s*\[\s*([^\]#]+?)\s*\]", line)
            key = re.match(r"\s*([\w.\"'-]+)\s*=", line)
            if header:
                here = table = _bare(header[1])
            elif key:
                here = f"{table}.{_bare(key[1])}" if table else _bare(key[1])
            else:
                continue
            if here == place:
                return number
            if place.startswith(f"{here}.") and len(here) > best_size:
                best, best_size = number, len(here)
        return best


def _bare(name: str) -> str:
    """Returns a key without quotes and blanks, so that all ways to write the key are equal."""
    return re.sub(r"[\"'\s]", "", name)
