"""Compiles files to a checked model, in one call."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from gidl.diagnostics.findings import Finding, Findings
from gidl.diagnostics.source import Source
from gidl.files.loader import Loader, default_search
from gidl.files.missing_include import point_at_includes
from gidl.files.names import same_files
from gidl.model import Model
from gidl.resolve.files import resolve
from gidl.rules import check_all
from gidl.wire.function_codes import codes_of


@dataclass(frozen=True, slots=True)
class Compiled:
    model: Model
    findings: tuple[Finding, ...]  # sorted by file and line
    sources: dict[str, Source]
    has_errors: bool  # True: the model is incomplete; nothing may be generated from it


def compile_files(
    paths: Iterable[str],
    search: Iterable[str] = (),
    *,
    wide: bool = False,
    defines: Iterable[str] = (),
) -> Compiled:
    """Reads, resolves and checks `paths` and the files that they include. Errors in the files
    become findings, never exceptions. With `wide`, `wstring` and `wchar` are read as `string`.
    `defines` are "NAME" or "NAME=VALUE" for the preprocessor."""
    with room_for_nesting():
        return _compile(list(paths), list(search), wide, defines)


def _compile(wanted: list[str], search: list[str], wide: bool, defines: Iterable[str]) -> Compiled:
    folders = tuple(Path(p) for p in search) or default_search(wanted)
    findings = Findings()
    loader = Loader(findings, folders, wide)
    if search:
        loader.check_search()
    loader.define(defines)
    vocabulary = loader.load_vocabulary()
    loader.load_all(wanted)
    for clash in same_files(loader.files):
        clash.report("G0021", findings, loader.sources)
    model = resolve(loader.files.values(), vocabulary, findings)
    check_all(model, findings, codes_of)
    point_at_includes(findings, folders)
    order = list(loader.files)
    return Compiled(model, tuple(findings.in_order(order)), loader.sources, findings.has_errors)


@contextmanager
def room_for_nesting() -> Iterator[None]:
    """Raises Python's recursion limit, because the parser allows 200 levels of nesting, and each
    level takes up to ten nested calls."""
    usual = sys.getrecursionlimit()
    sys.setrecursionlimit(max(usual, 20_000))
    try:
        yield
    finally:
        sys.setrecursionlimit(usual)
