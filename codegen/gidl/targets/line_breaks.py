"""Lays out generated text without a formatter: breaks long lines where the views allow it."""

from __future__ import annotations

from gidl.targets.groups import laid_out_groups


def laid_out(text: str, language: str) -> str:
    """Returns `text` with long lines broken, and with the empty lines that are usual in
    `language`."""
    python = language == "python"
    lines = laid_out_groups(text, closes_alone=python).split("\n")
    return "\n".join(_spaced(lines, python)).strip("\n") + "\n"


def _spaced(lines: list[str], python: bool) -> list[str]:
    """Puts two empty lines before and after each top-level block of Python. Leaves at most one
    empty line between other lines."""
    result: list[str] = []
    empty, block = 0, False  # `block`: the line is in a top-level class or function
    decorated = False  # the previous line decorates a top-level class or function
    for line in lines:
        if not line.strip():
            empty += 1
            continue
        indented = line[0] in " )]}"
        opens = line.startswith(("class ", "def ", "@"))
        wanted = min(empty, 1)
        if python and not indented and result and not decorated:
            if opens or block:
                wanted = 2
            block = opens
        elif python and not indented:
            block = opens
        decorated = line.startswith("@") if not indented else decorated
        result += [""] * wanted + [line.rstrip()]
        empty = 0
    return result
