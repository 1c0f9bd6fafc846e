"""Reads the project file gidl.toml: defaults for options of the command line."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gidl.cli.output import LANGUAGES
from gidl.cli.project_keys import OUTPUTS, wrong_with
from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Source
from gidl.model import Location

FILE = "gidl.toml"
_AT = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z")


@dataclass(frozen=True, slots=True)
class Project:
    """Defaults for options of the command line. Paths of folders are relative to the current
    folder."""

    file: Path | None = None
    roots: tuple[Path, ...] = (Path("idl"),)
    imports: tuple[Path, ...] = ()
    languages: tuple[str, ...] = LANGUAGES
    out: Path = Path("generated")
    outputs: Mapping[str, Path] = field(default_factory=dict)
    defines: tuple[str, ...] = ()
    wide: str | None = None
    strict: bool = False
    excepted: frozenset[str] = frozenset()


def find(start: Path) -> Path | None:
    """Returns the path of the project file in the folder `start`, or else in the nearest folder
    above that has a project file. Returns None if none of these folders has one."""
    start = start.absolute()
    for folder in (start, *start.parents):
        if (folder / FILE).is_file():
            return Path(os.path.relpath(folder / FILE, start))
    return None


def read(file: Path, findings: Findings, sources: dict[str, Source]) -> Project:
    """Returns the contents of a project file. Each mistake in the file becomes a finding with a
    line."""
    shown = file.as_posix()
    try:
        text = file.read_bytes().decode("utf-8")
    except UnicodeDecodeError as problem:
        findings.file_error(
            "G0023", shown, f"this file is not UTF-8, as TOML must be: {problem.reason}"
        )
        return Project(file)
    sources[shown] = Source(shown, shown, text)
    try:
        said = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        place = _AT.search(str(problem))
        line, column = (place[1], place[2]) if place else ("1", "1")
        at = Location(shown, int(line or text.count("\n") + 1), int(column or 1))
        findings.error("G0023", at, f"this file is not TOML: {_AT.sub('', str(problem))}")
        return Project(file)
    except RecursionError:
        findings.file_error("G0023", shown, "this file is not readable: lists are nested too deep")
        return Project(file)
    right: dict[str, Any] = {}
    for keys, value in _flat(said):
        wrong = wrong_with(keys, value, file.parent)
        if wrong is None:
            right[".".join(keys)] = value
        else:
            findings.error("G0023", Location(shown, line_of(text, keys), 1), *wrong)
    return _project(file, right)


def line_of(text: str, keys: tuple[str, ...]) -> int:
    """Returns the number of the line where the TOML statement that sets a key begins. `keys` is the
    path of the key. The function parses longer and longer beginnings of the text, because parsing
    succeeds only where a statement ends."""
    lines = [f"{line}\n" for line in text.split("\n")]
    begin = 1
    for end in range(1, len(lines) + 1):
        try:
            so_far: Any = tomllib.loads("".join(lines[:end]))
        except tomllib.TOMLDecodeError:
            continue
        for key in keys:
            so_far = so_far.get(key) if isinstance(so_far, dict) else None
        if so_far is not None:
            return begin
        begin = end + 1
    return 1


def _flat(said: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for key, value in said.items():
        if key == OUTPUTS and isinstance(value, dict):
            yield from (((key, language), folder) for language, folder in value.items())
        else:
            yield (key,), value


def _project(file: Path, right: Mapping[str, Any]) -> Project:
    def folder(text: str) -> Path:
        return Path(text) if Path(text).is_absolute() else Path(os.path.relpath(file.parent / text))

    usual = ["idl"] if (file.parent / "idl").is_dir() else []
    return Project(
        file,
        roots=tuple(folder(text) for text in right.get("roots", usual)),
        imports=tuple(folder(text) for text in right.get("imports", [])),
        languages=tuple(right.get("languages", LANGUAGES)),
        out=folder(right.get("out", "generated")),
        outputs={
            key.removeprefix(f"{OUTPUTS}."): folder(text)
            for key, text in right.items()
            if key.startswith(f"{OUTPUTS}.")
        },
        defines=tuple(right.get("defines", [])),
        wide=right.get("wide"),
        strict=right.get("strict", False),
        excepted=frozenset(right.get("except", [])),
    )
