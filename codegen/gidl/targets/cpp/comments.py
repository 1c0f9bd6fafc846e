"""The author's comments, as lines after `///`."""

from __future__ import annotations

from collections.abc import Iterable

from gidl.model import Facts
from gidl.targets import naming


def doc_lines(facts: Facts, note: str = "") -> tuple[str, ...]:
    return comment(naming.doc_lines(facts, note))


def comment(lines: Iterable[str]) -> tuple[str, ...]:
    """None of them goes on in the line of code after it, as one does that ends in a backslash, or
    in the trigraph for it."""
    return tuple(f"{line} ." if line.endswith(("\\", "??/")) else line for line in lines)
