"""Prints import lines in the order that linters expect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_WIDTH = 100


def import_order(name: str) -> tuple[int, str, str]:
    """Returns the sort key for imported names: CONSTANTS come first, then Classes, then all
    others."""
    name = name.partition(" as ")[0]
    kind = 0 if name.isupper() and len(name) > 1 else 1 if name[0].isupper() else 2
    return kind, name.lower(), name


def export_order(name: str) -> tuple[int, str]:
    """Returns the sort key for names in `__all__`: as for `import_order`, but capitals sort before
    small letters."""
    kind, _, _ = import_order(name)
    return kind, name


def private(names: Iterable[str]) -> list[str]:
    """Returns the texts that import `names` under private names, for example "Kind as _Kind". No
    name in an interface begins with an underscore, so no declaration can hide a name that is
    imported in this way."""
    return [f"{name} as _{name}" for name in names]


def import_lines(modules: Mapping[str, Iterable[str]]) -> list[str]:
    """Returns lines of the form `from module import names`, sorted by module."""
    lines: list[str] = []
    for module in sorted(modules):
        given = sorted(set(modules[module]), key=import_order)
        lines += [f"from {module} import {name}" for name in given if " as " in name]
        names = [name for name in given if " as " not in name]
        if not names:
            continue
        line = f"from {module} import {', '.join(names)}"
        if len(line) <= _WIDTH:
            lines.append(line)
        else:
            lines += [f"from {module} import (", *(f"    {name}," for name in names), ")"]
    return lines
