"""Looks in the search folders for what a file uses and nobody in the run has declared."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gidl.diagnostics import Finding, Findings

_MOST_FILES = 500
_MOST_BYTES = 1_000_000
_UNKNOWN = re.compile(r"unknown \w+ '(?:\w+::)*(\w+)'$")


def point_at_includes(findings: Findings, folders: Sequence[Path]) -> None:
    """Adds to findings of unknown names, where there is no other help, which file to include."""
    texts: dict[str, str] | None = None
    for index, finding in enumerate(findings.found):
        wanted = _wanted(finding)
        if wanted is None:
            continue
        if texts is None:
            texts = _texts(folders)
        declares = re.compile(
            rf"^[^/\n]*\b(?:struct|union|enum|interface|exception|bitmask|bitset)\s+{wanted}\b"
            rf"(?!\s*;)|^[^/\n]*\btypedef\b[^;]*\b{wanted}\b\s*[;\[]",
            re.MULTILINE,
        )
        for path, text in texts.items():
            if declares.search(text):
                hint = f"'{wanted}' is declared in {path}: #include \"{path}\""
                findings.found[index] = replace(finding, help=(hint,))
                break


def _wanted(finding: Finding) -> str | None:
    if finding.code != "G0102" or any(finding.help):
        return None
    found = _UNKNOWN.match(finding.message)
    return found[1] if found else None


def _texts(folders: Sequence[Path]) -> dict[str, str]:
    """Path as others include it -> text, of what can be read."""
    texts: dict[str, str] = {}
    for folder in folders:
        for place in sorted(folder.rglob("*.gidl"))[:_MOST_FILES]:
            try:
                if place.is_file() and place.stat().st_size <= _MOST_BYTES:
                    text = place.read_text(encoding="utf-8", errors="replace")
                    texts.setdefault(place.relative_to(folder).as_posix(), text)
            except OSError:
                continue
    return texts
