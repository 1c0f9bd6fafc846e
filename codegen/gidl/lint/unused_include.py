"""Lint: a file should use at least one name from each file that it includes, directly or
indirectly."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.lint.uses import uses
from gidl.model import File, Location, Model


def check(model: Model, findings: Findings) -> None:
    files = {file.path: file for file in model.files}
    for file in model.files:
        needed = {model.file_of(use.name) for use in uses(model, file)}
        for path in file.includes:
            if path in files and not needed & _reach(path, files) and files[path].declarations:
                findings.warning(
                    "G0912",
                    Location(file.path, 1, 1),
                    f"no name of '{path}' is used in this file",
                    f'leave out #include "{path}"',
                )


def _reach(path: str, files: dict[str, File]) -> set[str]:
    """Returns the path `path` and the paths of all files that this file includes, directly or
    indirectly."""
    reached: set[str] = set()
    work = [path]
    while work:
        now = work.pop()
        if now not in reached and now in files:
            reached.add(now)
            work += files[now].includes
    return reached
