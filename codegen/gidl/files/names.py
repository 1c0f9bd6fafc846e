"""Finds interface files, and names the files that are generated from them.

All code that needs the name of an output, a header or a Python module for the path of an interface
file must use this module.
"""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Source
from gidl.files.standard_modules import OURS, STANDARD
from gidl.syntax.keywords import PYTHON

SUFFIXES = (".gidl", ".idl")
_PACKAGES = {"gecos": "gecos_idl"}  # the Python package gecos is the runtime
_SHARED = frozenset(("robcl", "gecos_idl"))  # packages that may contain generated modules
_CPP_PARTS = ("types", "json", "calls", "interface", "client", "server")
_SPECIAL = frozenset(("__init__", "__main__", "__pycache__"))


def is_interface(path: str) -> bool:
    return path.lower().endswith(SUFFIXES)


def interfaces_below(folder: Path) -> list[Path]:
    """Returns the interface files in a folder and its subfolders, sorted. Hidden folders, for
    example .venv, are skipped. Links to folders are followed, but each folder is read once. If a
    folder cannot be read, raises an OSError that names the folder."""
    found: list[Path] = []
    read: set[Path] = set()
    starts = [folder] if folder.is_dir() else []
    while starts:
        # Links are followed last, so that a file in both a real and a linked folder gets the path
        # without the link.
        links: list[Path] = []
        for start in sorted(starts):
            _collect(start, found, read, links)
        starts = links
    return sorted(found)


def _collect(start: Path, found: list[Path], read: set[Path], links: list[Path]) -> None:
    work = [start]
    while work:
        folder = work.pop()
        real = folder.resolve()
        if real in read:
            continue
        read.add(real)
        with os.scandir(folder) as entries:
            for entry in entries:
                place = folder / entry.name
                if not entry.is_dir():
                    if is_interface(entry.name):
                        found.append(place)
                elif not entry.name.startswith("."):
                    (links if entry.is_symlink() else work).append(place)


def source_stem(path: str) -> str:
    """Returns the path without its suffix, for example "robcl/geometry". The paths of all generated
    files begin with this text."""
    for suffix in SUFFIXES:
        if path.lower().endswith(suffix):
            return path[: -len(suffix)]
    return path


def python_stem(path: str) -> str:
    """Returns the path of the Python module of an interface file. For "my-lab/2fast.gidl" this is
    "my_lab/_2fast": the name of the module is a valid identifier, and hides no module of the
    standard library or the runtime."""
    parts = [_identifier(part) for part in source_stem(path).split("/")]
    first = parts[0]
    if len(parts) > 1 and first in _PACKAGES:
        parts[0] = _PACKAGES[first]
    elif first in STANDARD or (first in OURS and (len(parts) == 1 or first not in _SHARED)):
        parts[0] = f"{first}_"
    return "/".join(parts)


def python_module(path: str) -> str:
    """Returns the dotted name of the Python module of an interface file, for example
    "robcl.geometry"."""
    return python_stem(path).replace("/", ".")


def outputs_of(path: str) -> dict[str, frozenset[str]]:
    """Returns, for each language, the paths of all files that gidl may generate from an interface
    file, whatever the file declares."""
    stem, module = source_stem(path), python_stem(path)
    return {
        "cpp": frozenset(f"{stem}_{part}.{kind}" for part in _CPP_PARTS for kind in ("hpp", "cpp")),
        "python": frozenset((f"{module}.py", f"{module}_types.py")),
        "lcm": frozenset((f"{stem}.lcm",)),
        "model": frozenset((f"{stem}.json",)),
    }


def _identifier(part: str) -> str:
    name = unicodedata.normalize("NFKC", part)  # Python normalizes identifiers to NFKC
    name = "".join(c if f"_{c}".isidentifier() else "_" for c in name)
    if not name.isidentifier():
        name = f"_{name}"
    return f"{name}_" if name in PYTHON or name in _SPECIAL else name


@dataclass(frozen=True, slots=True)
class Clash:
    """Two interface files whose generated files would have the same path."""

    path: str
    other: str
    what: str  # the shared output, for example "the Python module my_lab"

    def report(self, code: str, findings: Findings, sources: Mapping[str, Source]) -> None:
        shown, other = sources[self.path].shown, sources[self.other].shown
        message = f"this file generates {self.what}, as does {other}"
        findings.file_error(code, shown, message, "rename one of the two files")


def same_files(paths: Iterable[str]) -> Iterator[Clash]:
    """Yields pairs of files whose outputs have equal names in every language, for example foo.gidl
    and foo.idl."""
    first: dict[str, str] = {}
    for path in paths:
        other = first.setdefault(source_stem(path), path)
        if other != path:
            yield Clash(path, other, f"the files {source_stem(path)}_types.hpp …")


def same_modules(paths: Iterable[str]) -> Iterator[Clash]:
    """Yields pairs of files that clash in Python, for one of two reasons.

    Both files may generate the same module: for example my-lab.gidl and my_lab.gidl, or
    foo_types.gidl and foo.gidl, which generates foo_types.py for its types. Or the module of one
    file hides the package of the other file: for example lab.gidl and lab/lamp.gidl.
    """
    paths = list(paths)
    first: dict[str, str] = {}
    told: set[tuple[str, str]] = set()
    for path in paths:
        for name in (python_stem(path), f"{python_stem(path)}_types"):
            other = first.setdefault(name, path)
            if other != path and (path, other) not in told:
                told.add((path, other))
                yield Clash(path, other, f"the Python module {name.replace('/', '.')}")
    for path in paths:
        parts = python_stem(path).split("/")
        for depth in range(1, len(parts)):
            package = "/".join(parts[:depth])
            if package in first:
                what = f"the Python package {package.replace('/', '.')}"
                yield Clash(path, first[package], what)
