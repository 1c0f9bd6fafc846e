"""Writes depfiles for Make and Ninja: rules that name the files from which the output was made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from gidl.diagnostics.source import Source
from gidl.files.loader import COMMAND_LINE, PACKAGED, VOCABULARY


def depfile_text(
    outputs: Iterable[Path], sources: Mapping[str, Source], others: Iterable[Path]
) -> str:
    """Returns the text of a depfile with one rule. Every output depends on all files that gidl
    read, including included files, and on the files `others`. Every output also depends on the
    program files of gidl, because another version of gidl may write other output."""
    read = {
        _place(path, source)
        for path, source in sources.items()
        if source.shown not in ("-", COMMAND_LINE)
    }
    read |= {place.as_posix() for place in others}
    made = [_escaped(place.as_posix()) for place in sorted(outputs)]
    needs = [_escaped(place) for place in sorted(read | _own_files())]
    return " \\\n".join(made) + ": \\\n  " + " \\\n  ".join(needs) + "\n"


def _place(path: str, source: Source) -> str:
    return (PACKAGED / VOCABULARY).as_posix() if path == VOCABULARY else source.shown


def _own_files() -> set[str]:
    here = Path(__file__).parents[1]
    return {path.as_posix() for kind in ("py", "j2", "gidl") for path in here.rglob(f"*.{kind}")}


def _escaped(path: str) -> str:
    for special, written in (("\\", "\\\\"), (" ", "\\ "), ("#", "\\#"), ("$", "$$")):
        path = path.replace(special, written)
    return path
