"""What several verbs of the command line share: their files, what was found, exit statuses."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from gidl.compile import Compiled, compile_files
from gidl.diagnostics import Finding, Printer, Severity, as_json, as_text
from gidl.file_names import interfaces_below
from gidl.report_formats import as_github_actions, as_sarif
from gidl.source import Source

FINE, FAILED, USAGE, FINDINGS = 0, 1, 2, 100

PRINTERS: dict[str, Printer] = {
    "text": as_text,
    "json": as_json,
    "sarif": as_sarif,
    "github-actions": as_github_actions,
}


def add_files(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files", nargs="*", metavar="FILE", help="- reads stdin; idl/ when left out"
    )
    parser.add_argument(
        "-I", dest="search", action="append", default=[], metavar="DIR", help="where includes begin"
    )
    parser.add_argument(
        "--wide", choices=("utf8",), help="read wstring and wchar as string, which is UTF-8"
    )
    parser.add_argument("--error-format", choices=sorted(PRINTERS), default="text")
    parser.set_defaults(prints=False)


def files_of(chosen: argparse.Namespace) -> list[str] | None:
    """The files named, else those of idl/; None (and a message) where there are none."""
    if chosen.files:
        return list(chosen.files)
    found = [place.as_posix() for place in interfaces_below(Path("idl"))]
    if not found:
        print("gidl: no files named, and there is no idl/ folder here with any", file=sys.stderr)
        return None
    return found


def compiled_from(chosen: argparse.Namespace, files: list[str]) -> Compiled:
    """Compiles as the command line says. What was found is the caller's to show."""
    return compile_files(files, chosen.search, wide=chosen.wide is not None)


def show(
    chosen: argparse.Namespace,
    findings: Iterable[Finding],
    sources: Mapping[str, Source],
    summary: str = "",
) -> None:
    """Prints all findings of a run, once: text to stderr, with a last line that counts them; other
    formats are a whole report, to stdout unless the verb prints something else there."""
    found = list(findings)
    text = PRINTERS[chosen.error_format](found, sources)
    is_text = chosen.error_format == "text"
    (sys.stderr if is_text or chosen.prints else sys.stdout).write(text)
    if is_text and found:
        errors = sum(f.severity is Severity.ERROR for f in found)
        counted = f"{count(errors, 'error')}, {count(len(found) - errors, 'warning')}"
        print(f"gidl: {summary or counted}", file=sys.stderr)


def count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
