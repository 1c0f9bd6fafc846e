"""Import lines in the order that readers and linters expect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_WIDTH = 100


def import_order(name: str) -> tuple[int, str, str]:
    """CONSTANTS, then Classes, then everything else."""
    name = name.partition(" as ")[0]
    kind = 0 if name.isupper() and len(name) > 1 else 1 if name[0].isupper() else 2
    return kind, name.lower(), name


def export_order(name: str) -> tuple[int, str]:
    """The order of `__all__`: the same, but capitals come first everywhere."""
    kind, _, _ = import_order(name)
    return kind, name


def private(names: Iterable[str]) -> list[str]:
    """How a module brings in what it needs itself: "Kind as _Kind". No name of an interface begins
    with an underscore, so none can hide it."""
    return [f"{name} as _{name}" for name in names]


def import_lines(modules: Mapping[str, Iterable[str]]) -> list[str]:
    """`from module import names` for each module that gives any, by module."""
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
