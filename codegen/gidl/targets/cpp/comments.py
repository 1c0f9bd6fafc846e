"""Prepares the author's comments for lines that begin with `///`."""

from __future__ import annotations

from collections.abc import Iterable

from gidl.model import Facts
from gidl.targets import naming


def doc_lines(facts: Facts, note: str = "") -> tuple[str, ...]:
    return comment(naming.doc_lines(facts, note))


def comment(lines: Iterable[str]) -> tuple[str, ...]:
    """Adds a full stop to each line that ends in a backslash, or in the trigraph for a backslash.
    Without the full stop, the compiler would read the next line of code as a part of the
    comment."""
    return tuple(f"{line} ." if line.endswith(("\\", "??/")) else line for line in lines)
