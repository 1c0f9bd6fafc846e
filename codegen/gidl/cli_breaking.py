"""`gidl breaking`: what a change of the interfaces breaks."""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from gidl.cli_shared import FAILED, FINDINGS, FINE, USAGE, add_files, files_of, show
from gidl.compile import Compiled, compile_files
from gidl.source import Source


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = verbs.add_parser("breaking", help="report what a change breaks")
    add_files(parser)
    parser.add_argument(
        "--against",
        required=True,
        metavar="DIR|git#ref=REF",
        help="the interfaces before: a folder, or idl/ of a commit (git#ref=main,subdir=idl)",
    )
    parser.set_defaults(command=run)


def run(chosen: argparse.Namespace) -> int:
    from gidl.breaking import CATEGORIES, category_of, compare
    from gidl.breaking.against import AgainstError, baseline

    files = files_of(chosen)
    if files is None:
        return USAGE
    new = compile_files(files, chosen.search)
    if new.has_errors:
        show(chosen, new.findings, new.sources)
        return FINDINGS
    try:
        with baseline(chosen.against, _subfolder(chosen)) as before:
            old = compile_files(before.files, [str(before.folder)])
            old_sources = _relabelled(old, before.label)
            label = before.label
    except AgainstError as problem:
        print(f"gidl: --against: {problem}", file=sys.stderr)
        return FAILED
    if old.has_errors:
        show(chosen, old.findings, old.sources)
        print(f"gidl: --against: {chosen.against} has errors itself", file=sys.stderr)
        return FAILED
    found = compare(old.model, new.model, label)
    counts = Counter(category_of(f.code) for f in found)
    summary = ", ".join(f"{counts[c]} {c}" for c in CATEGORIES)
    show(chosen, found, {**new.sources, **old_sources}, summary)
    return FINDINGS if found else FINE


def _subfolder(chosen: argparse.Namespace) -> str:
    """Where the interfaces lie in a commit: where they lie now."""
    return str(chosen.search[0]).strip("/") if chosen.search else "idl"


def _relabelled(old: Compiled, label: str) -> dict[str, Source]:
    return {
        f"{label}{path}": Source(path, f"{label}{path}", source.text)
        for path, source in old.sources.items()
    }
