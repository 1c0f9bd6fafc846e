"""Finds the file that declares an unknown name, so that the error can tell the author to include
this file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gidl.diagnostics.findings import Finding, Findings
from gidl.files.names import interfaces_below

_MOST_FILES = 500
_MOST_BYTES = 1_000_000
_LONGEST_LINE = 500
_UNKNOWN = re.compile(r"unknown \w+ '(?:\w+::)*(\w+)'$")
_DECLARED = re.compile(
    r"^[^/]*\b(?:struct|union|enum|interface|exception|bitmask|bitset)\s+(\w+)\b(?!\s*;)"
    r"|^[^/]*\btypedef\b[^;/]*\b(\w+)\s*(?:\[[^;]*)?;"
)


def point_at_includes(findings: Findings, folders: Sequence[Path]) -> None:
    """Adds a help line, which names the file to include, to each finding about an unknown name. A
    finding that already has a help line is not changed."""
    homes: dict[str, str] | None = None
    for index, finding in enumerate(findings.found):
        wanted = _wanted(finding)
        if wanted is None:
            continue
        if homes is None:
            homes = _homes(folders)
        if wanted in homes:
            hint = f"'{wanted}' is declared in {homes[wanted]}: #include \"{homes[wanted]}\""
            findings.found[index] = replace(finding, help=(hint,))


def _wanted(finding: Finding) -> str | None:
    if finding.code != "G0102" or any(finding.help):
        return None
    found = _UNKNOWN.match(finding.message)
    return found[1] if found else None


def _homes(folders: Sequence[Path]) -> dict[str, str]:
    """Maps each declared name to the first file that declares the name. The file is given by the
    path that `#include` needs."""
    homes: dict[str, str] = {}
    for folder in folders:
        try:
            places = interfaces_below(folder)[:_MOST_FILES]
        except OSError:
            continue  # without this folder, some findings lack a help line
        for place in places:
            try:
                if not place.is_file() or place.stat().st_size > _MOST_BYTES:
                    continue
                text = place.read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue  # the loader reports the file if another file includes it
            path = place.relative_to(folder).as_posix()
            for line in text.splitlines():
                for of_its_own, alias in _DECLARED.findall(line[:_LONGEST_LINE]):
                    homes.setdefault(of_its_own or alias, path)
    return homes
