"""The parts that subcommands share: options, the choice of files, and the printing of findings."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from gidl.cli import project
from gidl.cli.project_keys import DEFINE, WIDE
from gidl.compile import Compiled, compile_files
from gidl.diagnostics.findings import Finding, Findings, Printer, Severity, as_json, as_text
from gidl.diagnostics.report_formats import as_github_actions, as_sarif
from gidl.diagnostics.source import Source
from gidl.files.loader import absolute, default_search
from gidl.files.names import interfaces_below

FINE, FAILED, USAGE, FINDINGS = 0, 1, 2, 100

WHEN_LEFT_OUT = (
    "interface files, or - for stdin; default: all files in the roots of gidl.toml, or in idl/"
)


def _sarif(findings: list[Finding], sources: Mapping[str, Source]) -> str:
    from gidl.cli.explain import all_titles

    return as_sarif(findings, sources, dict(all_titles()))


PRINTERS: dict[str, Printer] = {
    "text": as_text,
    "json": as_json,
    "sarif": _sarif,
    "github-actions": as_github_actions,
}


def add_files(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="*", metavar="FILE", help=WHEN_LEFT_OUT)
    add_reading(parser)
    parser.add_argument(
        "--strict", action=argparse.BooleanOptionalAction, help="treat warnings as errors"
    )
    parser.add_argument("--error-format", choices=sorted(PRINTERS), default="text")
    parser.set_defaults(prints=False, settles=True)


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Adds the options for reading files: -I, -D and --wide."""
    parser.add_argument(
        "-I",
        dest="search",
        action="append",
        default=[],
        metavar="DIR",
        help="folder to search for included files",
    )
    parser.add_argument(
        "-D",
        dest="defines",
        action="append",
        default=[],
        type=_constant,
        metavar="NAME[=VALUE]",
        help="define a constant for #if and #ifdef",
    )
    parser.add_argument(
        "--wide", choices=WIDE, help="read wstring and wchar as string, which is UTF-8"
    )


def add_except(parser: argparse.ArgumentParser, meaning: str) -> None:
    parser.add_argument("--except", dest="excepted", type=_codes, metavar="CODE,...", help=meaning)


def _codes(text: str) -> frozenset[str]:
    from gidl.cli.explain import lint_rules

    codes = frozenset(part.strip().upper() for part in text.split(","))
    for code in sorted(codes):
        if code not in lint_rules():
            raise argparse.ArgumentTypeError(f"there is no lint rule with the code {code}")
    return codes


def _constant(text: str) -> str:
    if not DEFINE.match(text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a constant: write NAME or NAME=VALUE")
    return text


def settle(chosen: argparse.Namespace) -> bool:
    """Completes the options of the command line from gidl.toml. If gidl.toml has a mistake, reports
    it and returns False."""
    findings = Findings()
    sources: dict[str, Source] = {}
    file = project.find(Path.cwd())
    said = project.Project() if file is None else project.read(file, findings, sources)
    if findings.found:
        show(chosen, findings.found, sources)
        return False
    named = vars(chosen)
    search: list[str] = named.get("search") or []
    chosen.project = said
    chosen.roots = [Path(folder) for folder in search[:1]]
    chosen.search = search
    if file is not None:
        own = [*said.roots, *said.imports]
        elsewhere = [name for name in named["files"] if not _is_below(name, own)]
        usual = [] if search else default_search(elsewhere)
        chosen.roots = chosen.roots or list(said.roots)
        chosen.search = [*search, *map(str, (*own, *usual))]
    chosen.defines = [*said.defines, *(named.get("defines") or [])]
    chosen.wide = named.get("wide") or said.wide
    chosen.strict = said.strict if named.get("strict") is None else chosen.strict
    chosen.lang = named.get("lang") or said.languages
    chosen.outputs = said.outputs if named.get("out") is None else {}
    chosen.out = named.get("out") or said.out
    chosen.excepted = said.excepted if named.get("excepted") is None else chosen.excepted
    return True


def _is_below(name: str, folders: Iterable[Path]) -> bool:
    place = absolute(Path(name))
    return any(place.is_relative_to(absolute(folder)) for folder in folders)


def files_of(chosen: argparse.Namespace) -> list[str] | None:
    """Returns the files named on the command line, or else all interface files in the root folders.
    If there are none, prints a message and returns None."""
    if chosen.files:
        return list(chosen.files)
    roots = chosen.project.roots
    found = [place.as_posix() for root in roots for place in interfaces_below(root)]
    if found:
        return list(dict.fromkeys(found))
    if chosen.project.file is None:
        there = (
            "there is no gidl.toml, and idl/ in the current folder has no interface "
            "files; name files, or run gidl in the folder of your project"
        )
    else:
        there = (
            f"the roots of {chosen.project.file} have no interface files; name files, or "
            "correct the key roots"
        )
    print(f"gidl: no files named, and {there}", file=sys.stderr)
    return None


def compiled_from(chosen: argparse.Namespace, files: list[str]) -> Compiled:
    """Compiles `files` with the options of the command line and of gidl.toml. The caller must print
    the findings in the result."""
    return compile_files(files, chosen.search, wide=chosen.wide is not None, defines=chosen.defines)


def strictly(chosen: argparse.Namespace, compiled: Compiled) -> Compiled:
    """Returns the compiled files; with --strict, their warnings become errors."""
    if not chosen.strict or not compiled.findings:
        return compiled
    return replace(compiled, findings=tuple(as_errors(compiled.findings)), has_errors=True)


def as_errors(findings: Iterable[Finding]) -> list[Finding]:
    return [replace(found, severity=Severity.ERROR) for found in findings]


def show(
    chosen: argparse.Namespace,
    findings: Iterable[Finding],
    sources: Mapping[str, Source],
    summary: str = "",
) -> None:
    """Prints all findings of a run; call it only once. A text report goes to stderr and ends with a
    line that counts the findings. A report in another format goes to stdout, or to stderr if the
    command prints its result on stdout."""
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
