"""Findings are errors and warnings. All stages of a run collect findings, and the command prints
them at its end."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from enum import Enum

from gidl.diagnostics.source import Source, Span
from gidl.model import Location

MAX_FINDINGS = 100  # the text output prints at most this number of findings
_MAX_WIDTH = 140  # a quoted source line is cut to this number of characters


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Note:
    """A further location of a finding, with a text such as "first declared here"."""

    text: str
    location: Location


@dataclass(frozen=True, slots=True)
class Finding:
    code: str  # such as "G0102": `gidl explain G0102` explains the code
    severity: Severity
    message: str
    location: Location | None  # None: the finding is not about a particular line
    length: int = 0  # number of characters to underline; 0: underline one word
    help: tuple[str, ...] = ()
    notes: tuple[Note, ...] = ()
    shown: str | None = None  # path of the file if `location` is None


_Key = tuple[str, Location | str | None, str]


def _key(finding: Finding) -> _Key:
    return (finding.code, finding.location or finding.shown, finding.message)


@dataclass(slots=True)
class Findings:
    """All findings so far. A finding with equal code, location and message is added only once."""

    found: list[Finding] = field(default_factory=list)
    _seen: set[_Key] = field(default_factory=set)

    def error(
        self,
        code: str,
        at: Span | Location,
        message: str,
        *help_lines: str,
        notes: tuple[Note, ...] = (),
    ) -> None:
        self._add(code, Severity.ERROR, at, message, help_lines, notes)

    def warning(
        self,
        code: str,
        at: Span | Location,
        message: str,
        *help_lines: str,
        notes: tuple[Note, ...] = (),
    ) -> None:
        self._add(code, Severity.WARNING, at, message, help_lines, notes)

    def warning_once(self, code: str, at: Span | Location, message: str, *help_lines: str) -> None:
        """Adds a warning unless the run already has a finding with the code `code`."""
        if all(finding.code != code for finding in self.found):
            self.warning(code, at, message, *help_lines)

    def take(self, others: Findings, without: Iterable[range]) -> None:
        """Adds the findings of `others`, except those that are located in the line ranges
        `without`."""
        for finding in others.found:
            place = finding.location
            if place is None or not any(place.line in lines for lines in without):
                self._keep(finding)

    def forget_after(self, count: int) -> None:
        """Removes all findings after the first `count`. A removed finding may be added again."""
        self._seen.difference_update(map(_key, self.found[count:]))
        del self.found[count:]

    def file_error(self, code: str, shown: str, message: str, *help_lines: str) -> None:
        """Adds an error about a whole file, for example a file that cannot be read."""
        self._keep(Finding(code, Severity.ERROR, message, None, 0, help_lines, (), shown))

    def _add(
        self,
        code: str,
        severity: Severity,
        at: Span | Location,
        message: str,
        help_lines: tuple[str, ...],
        notes: tuple[Note, ...],
    ) -> None:
        if isinstance(at, Span):
            location, length = at.location, at.end - at.start
        else:
            location, length = at, 0
        shown_help = tuple(line for line in help_lines if line)
        self._keep(Finding(code, severity, message, location, length, shown_help, notes))

    def _keep(self, finding: Finding) -> None:
        key = _key(finding)
        if key not in self._seen:
            self._seen.add(key)
            self.found.append(finding)

    @property
    def has_errors(self) -> bool:
        return any(f.severity is Severity.ERROR for f in self.found)

    def in_order(self, file_order: list[str]) -> list[Finding]:
        """Returns the findings, sorted by file (in the order of `file_order`), then by line and
        column."""
        rank = {path: i for i, path in enumerate(file_order)}

        def key(finding: Finding) -> tuple[int, int, int, str, str]:
            place = finding.location
            if place is None:
                return (-1, 0, 0, finding.code, finding.message)
            where = rank.get(place.file, len(rank))
            return (where, place.line, place.column, finding.code, finding.message)

        return sorted(self.found, key=key)


def suggestion(wrong: str, known: Mapping[str, str]) -> str:
    """Returns a "did you mean" help line, or "" if no known name is similar to `wrong`. `known`
    maps each known name to the place of its declaration, or to ""."""
    by_lower = {name.lower(): name for name in known}
    close = get_close_matches(wrong.lower(), list(by_lower), n=1, cutoff=0.66)
    if not close:
        return ""
    name = by_lower[close[0]]
    place = f" it is declared in {known[name]}" if known[name] else ""
    return f"did you mean '{name}'?{place}"


# ---------------------------------------------------------------------------------------------
# Printing


Printer = Callable[[list[Finding], Mapping[str, Source]], str]


def as_text(findings: list[Finding], sources: Mapping[str, Source]) -> str:
    """Returns the findings as text, with one block per finding, as compilers print them."""
    blocks = [_block(f, sources) for f in findings[:MAX_FINDINGS]]
    if len(findings) > MAX_FINDINGS:
        blocks.append(f"and {len(findings) - MAX_FINDINGS} more\n")
    return "".join(blocks)


def _block(finding: Finding, sources: Mapping[str, Source]) -> str:
    head = f"{finding.severity.value}[{finding.code}]: {finding.message}\n"
    if finding.location is None:
        text = f"{finding.shown}: {head}" if finding.shown else head
    else:
        text = _place(finding.location, sources) + head
        text += _quote(finding.location, finding.length, sources)
    for line in finding.help:
        text += f"      = help: {line}\n"
    for note in finding.notes:
        text += f"{_place(note.location, sources)}note: {note.text}\n"
        text += _quote(note.location, 0, sources)
    return text


def _place(location: Location, sources: Mapping[str, Source]) -> str:
    source = sources.get(location.file)
    shown = source.shown if source else location.file
    return f"{shown}:{location.line}:{location.column}: "


def _quote(location: Location, length: int, sources: Mapping[str, Source]) -> str:
    source = sources.get(location.file)
    if source is None:
        return ""
    raw = source.line(location.line)
    start = location.column - 1
    if length == 0:
        word = re.compile(r"@?\w+|.").match(raw, start)
        length = len(word.group()) if word else 1
    length = max(1, min(length, len(raw) - start))
    first = max(0, start - _MAX_WIDTH // 2) if len(raw) > _MAX_WIDTH else 0
    before = _printable(raw[first:start])
    under = _printable(raw[start : start + length])
    shown = before + under + _printable(raw[start + length : first + _MAX_WIDTH])
    caret = "^" + "~" * (min(len(under), _MAX_WIDTH) - 1)
    return f"{location.line:5} | {shown.rstrip()}\n      | {' ' * len(before)}{caret}\n"


def _printable(text: str) -> str:
    """Returns `text` with four spaces for each tab, and U+FFFD for each other unprintable
    character."""
    return "".join(
        c if c.isprintable() else "    " if c == "\t" else "\N{REPLACEMENT CHARACTER}" for c in text
    )


def as_json(findings: list[Finding], sources: Mapping[str, Source]) -> str:
    """Returns all findings as a JSON array with one object per finding."""
    return json.dumps([_json_of(f, sources) for f in findings], indent=2) + "\n"


def _json_of(finding: Finding, sources: Mapping[str, Source]) -> dict[str, object]:
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": finding.message,
        **_json_place(finding.location, finding.shown, sources),
        "length": finding.length,
        "help": list(finding.help),
        "notes": [
            {"message": n.text, **_json_place(n.location, None, sources)} for n in finding.notes
        ],
    }


def _json_place(
    location: Location | None, shown: str | None, sources: Mapping[str, Source]
) -> dict[str, object]:
    if location is None:
        return {"file": shown, "line": None, "column": None}
    source = sources.get(location.file)
    return {
        "file": source.shown if source else location.file,
        "line": location.line,
        "column": location.column,
    }
