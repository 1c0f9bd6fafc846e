"""`gidl breaking`: reports incompatible changes between an older version of the interfaces and this
one."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path

from gidl.cli.shared import (
    FAILED,
    FINDINGS,
    FINE,
    USAGE,
    add_files,
    compiled_from,
    files_of,
    show,
    strictly,
)
from gidl.compile import compile_files
from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Source
from gidl.files.loader import default_search
from gidl.files.names import source_stem

_OLD = "old:"  # prefix, in findings, of the paths of the older interface files


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = verbs.add_parser("breaking", help="report incompatible changes of the interfaces")
    add_files(parser)
    parser.add_argument(
        "--against",
        required=True,
        metavar="DIR|git#ref=REF",
        help="where the older interfaces are: a folder, or a commit (git#ref=main,subdir=idl)",
    )
    parser.set_defaults(command=run)


def run(chosen: argparse.Namespace) -> int:
    from gidl.breaking import CATEGORIES, category_of, compare
    from gidl.breaking.against import AgainstError, baseline

    files = files_of(chosen)
    if files is None:
        return USAGE
    if "-" in files:
        print(
            "gidl: `gidl breaking` cannot read stdin, because stdin has no older version; "
            "name files",
            file=sys.stderr,
        )
        return USAGE
    new = strictly(chosen, compiled_from(chosen, files))
    if new.has_errors:
        show(chosen, new.findings, new.sources)
        return FINDINGS
    read = {source_stem(file.path) for file in new.model.files}
    try:
        with baseline(chosen.against, _roots(chosen, files)) as before:
            search = [str(root.folder) for root in before.roots]
            named = before.files(read if chosen.files else None)
            old = compile_files(
                named,
                search + [each for each in chosen.search if Path(each) not in chosen.roots],
                wide=chosen.wide is not None,
                defines=chosen.defines,
            )
            old_sources = {
                path: Source(path, before.shown(source.shown), source.text)
                for path, source in old.sources.items()
            }
    except AgainstError as problem:
        if chosen.error_format != "text":
            unread = Findings()
            unread.file_error("G0025", chosen.against, str(problem))
            show(chosen, unread.found, {})
        print(f"gidl: --against: {problem}", file=sys.stderr)
        return FAILED
    if old.has_errors:
        show(chosen, old.findings, old_sources)
        print(f"gidl: --against: {chosen.against} has errors in its interfaces", file=sys.stderr)
        return FAILED
    found = compare(old.model, new.model, _OLD)
    counts = Counter(category_of(f.code) for f in found)
    summary = ", ".join(f"{counts[c]} {c}" for c in CATEGORIES)
    sources = new.sources | {f"{_OLD}{path}": source for path, source in old_sources.items()}
    show(chosen, found, sources, summary)
    return FINDINGS if found else FINE


def _roots(chosen: argparse.Namespace, files: list[str]) -> list[Path]:
    """Returns the root folders of the interface files. `gidl breaking` reads older versions of
    these folders."""
    if chosen.roots or not chosen.files:
        return chosen.roots or list(chosen.project.roots)
    roots = list(default_search(files))
    alone = [Path(f) for f in files if not any(Path(f).is_relative_to(root) for root in roots)]
    return list(dict.fromkeys([*roots, *(place.parent for place in alone)]))
