"""The files of the tests that are accepted and can be generated, as few sets: files that declare
no name twice are compiled together."""

from __future__ import annotations

from pathlib import Path

from building import TREE, Set
from gidl.compile import compile_files
from gidl.model import EnumDeclaration, Model

LARGEST = 10  # files of a set
# Events and inward streams are refused by gen; classes written by hand would have to be there.
LEFT_OUT = ("@event", 'dir="in"', "own::")


def corpus() -> list[Set]:
    gidl, idl = TREE / "tests" / "gidl", TREE / "tests" / "idl"
    folders = (gidl / "good", gidl / "preprocessor", idl, *(f for f in idl.iterdir() if f.is_dir()))
    found = [file for folder in folders for file in folder.glob("*.gidl")]
    roots = tuple(dict.fromkeys(f.parent for f in sorted(found)))
    groups: list[tuple[set[str], list[Path]]] = []
    for file in sorted(found):
        if any(word in file.read_text(errors="replace") for word in LEFT_OUT):
            continue
        names = _names(compile_files([str(file)], [*map(str, roots), str(TREE / "idl")]).model)
        for taken, files in groups:
            if len(files) < LARGEST and not taken & names:
                break
        else:
            taken, files = set(), []
            groups.append((taken, files))
        taken |= names
        files.append(file)
    return [Set(f"corpus{i}", tuple(files), roots) for i, (_, files) in enumerate(groups, 1)]


def _names(model: Model) -> set[str]:
    """All that a file declares, but for modules: the first name of each declaration."""
    names = set()
    for file in model.files:
        if file.path.startswith(("robcl/", "gecos/")):
            continue
        for declaration in file.declarations:
            names.add(declaration.name.lower())
            if isinstance(declaration, EnumDeclaration):
                scope = declaration.name.rpartition("::")[0]
                names |= {f"{scope}::{e.name.lower()}" for e in declaration.enumerators}
                names |= {e.name.lower() for e in declaration.enumerators if not scope}
    return names
