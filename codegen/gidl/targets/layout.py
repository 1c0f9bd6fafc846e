"""How generated text is laid out: without a formatter, by what the views say of long lines."""

from __future__ import annotations

from gidl.targets.groups import laid_out_groups


def laid_out(text: str, language: str) -> str:
    """`text` with as many empty lines as the language's readers expect, and no long line."""
    python = language == "python"
    lines = laid_out_groups(text, closes_alone=python).split("\n")
    return "\n".join(_spaced(lines, python)).strip("\n") + "\n"


def _spaced(lines: list[str], python: bool) -> list[str]:
    """Two empty lines around what stands at the left edge of Python, else one at most."""
    result: list[str] = []
    empty, block = 0, False  # block: inside a class or function at the left edge
    decorated = False  # after a decorator of it
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
