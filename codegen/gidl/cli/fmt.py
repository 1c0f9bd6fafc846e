"""`gidl fmt`: formats files, or reports the files that are not formatted."""

from __future__ import annotations

import argparse
import difflib
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path

from gidl.cli.output import replace_texts
from gidl.cli.shared import FINDINGS, FINE, USAGE, WHEN_LEFT_OUT, count, files_of, show
from gidl.compile import room_for_nesting
from gidl.diagnostics.findings import Findings, Severity
from gidl.diagnostics.source import Source
from gidl.files.loader import read_text
from gidl.fmt import UnreadableError, layout
from gidl.model import Location
from gidl.syntax.parser import parse


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = verbs.add_parser("fmt", help="format files in the canonical layout")
    parser.add_argument("files", nargs="*", metavar="FILE", help=WHEN_LEFT_OUT)
    parser.add_argument("--check", action="store_true", help="write nothing; show the differences")
    parser.set_defaults(command=run, error_format="text", prints=False, settles=True)


@dataclass(frozen=True, slots=True)
class _Formatted:
    shown: str
    before: str
    after: str


def run(chosen: argparse.Namespace) -> int:
    files = files_of(chosen)
    if files is None:
        return USAGE
    findings = Findings()
    sources: dict[str, Source] = {}
    with room_for_nesting():
        done = [_formatted(shown, findings, sources) for shown in dict.fromkeys(files)]
    show(chosen, findings.in_order(list(sources)), sources)
    changed = [one for one in done if one is not None and one.after != one.before]
    if chosen.check:
        for one in changed:
            sys.stdout.write(_difference(one))
    else:
        for laid in done:
            if laid is not None and laid.shown == "-":
                sys.stdout.write(laid.after)
        replace_texts({Path(one.shown): one.after for one in changed if one.shown != "-"})
    if files != ["-"]:
        mend = shlex.join(["gidl", "fmt", *(one.shown for one in changed if chosen.files)])
        _summary(chosen.check, len(done), len(changed), done.count(None), mend)
    return FINDINGS if findings.has_errors or (chosen.check and changed) else FINE


def _summary(check: bool, files: int, changed: int, unread: int, mend: str) -> None:
    sys.stdout.flush()
    left = f", {unread} left unchanged because of errors" if unread else ""
    if not check:
        print(f"gidl: {count(files, 'file')}, {changed} formatted{left}")
    elif changed:
        told = f"{changed} of {count(files, 'file')} not formatted{left}"
        print(f"gidl: {told}; to fix, run: {mend}")
    elif files > unread:
        print(f"gidl: {count(files - unread, 'file')} already formatted{left}")


def _formatted(shown: str, findings: Findings, sources: dict[str, Source]) -> _Formatted | None:
    """Returns the text before and after formatting. If the file is not valid .gidl, adds a finding
    and returns None."""
    text = read_text(shown, findings)
    if text is None:
        return None
    source = Source(shown, shown, text)
    sources[shown] = source
    wrong = Findings()
    parse(source, wrong, {}, lambda _include: None, wide=True)
    if wrong.has_errors:
        findings.found += [f for f in wrong.found if f.severity is Severity.ERROR]
        return None
    try:
        return _Formatted(shown, text, layout(text))
    except UnreadableError as problem:
        findings.error(
            "G0014",
            Location(shown, problem.line, 1),
            f"this file cannot be formatted: this line {problem}",
            "each branch of an #if must close the braces that the branch opens, and '#' must be "
            "the first character of its line",
        )
        return None


def _difference(one: _Formatted) -> str:
    lines = difflib.unified_diff(
        one.before.splitlines(keepends=True),
        one.after.splitlines(keepends=True),
        one.shown,
        f"{one.shown} (formatted)",
    )
    return "".join(line if line.endswith("\n") else line + "\n" for line in lines)
