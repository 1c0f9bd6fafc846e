"""Import lines in the order that readers and linters expect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_WIDTH = 100


def import_order(name: str) -> tuple[int, str, str]:
    """CONSTANTS, then Classes, then everything else."""
    kind = 0 if name.isupper() and len(name) > 1 else 1 if name[0].isupper() else 2
    return kind, name.lower(), name


def export_order(name: str) -> tuple[int, str]:
    """The order of `__all__`: the same, but capitals come first everywhere."""
    kind, _, _ = import_order(name)
    return kind, name


def import_lines(modules: Mapping[str, Iterable[str]]) -> list[str]:
    """`from module import names` for each module that gives any, by module."""
    lines: list[str] = []
    for module in sorted(modules):
        names = sorted(set(modules[module]), key=import_order)
        if not names:
            continue
        line = f"from {module} import {', '.join(names)}"
        if len(line) <= _WIDTH:
            lines.append(line)
        else:
            lines += [f"from {module} import (", *(f"    {name}," for name in names), ")"]
    return lines
