"""`gidl lint`: reports what could be better in interface files that have no errors."""

from __future__ import annotations

import argparse
import sys

from gidl.cli.shared import (
    FINDINGS,
    FINE,
    USAGE,
    add_except,
    add_files,
    as_errors,
    compiled_from,
    count,
    files_of,
    show,
)


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = verbs.add_parser("lint", help="report possible improvements of valid files")
    add_files(parser)
    add_except(parser, "rules to skip, for example G0907")
    parser.set_defaults(command=run)


def run(chosen: argparse.Namespace) -> int:
    from gidl.lint import lint

    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = compiled_from(chosen, files)
    findings = list(compiled.findings)
    if not compiled.has_errors:
        findings += [f for f in lint(compiled.model) if f.code not in chosen.excepted]
        order = {path: number for number, path in enumerate(compiled.sources)}
        findings.sort(
            key=lambda f: (order[f.location.file], f.location.line) if f.location else (-1, 0)
        )
    show(chosen, as_errors(findings) if chosen.strict else findings, compiled.sources)
    if not findings and chosen.error_format == "text":
        print(f"gidl: no lint findings in {count(len(files), 'file')}", file=sys.stderr)
    return FINDINGS if findings else FINE
