"""Explains the codes of findings, with the sections of pages.md."""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from gidl.rules import no_effect

_HEAD = re.compile(r"^## (G\d{4}) (.+)$", re.MULTILINE)


def page(code: str) -> str | None:
    """Returns title and text of the page of a code. Other spellings of the code, for example
    "g102", are accepted."""
    found = _pages().get(_normal(code))
    if found is None:
        return None
    title, text = found
    return f"{_normal(code)}: {title}\n\n{text}"


def all_titles() -> list[tuple[str, str]]:
    return [(code, title) for code, (title, _) in sorted(_pages().items())]


def lint_rules() -> list[str]:
    """Returns the codes that `--except` accepts: the codes of the lint rules, and the code of the
    warning about annotations without effect."""
    return [code for code, _ in all_titles() if code.startswith("G09") or code == no_effect.CODE]


def closest(code: str) -> str:
    """Returns a suggestion for an unknown code, for example ", did you mean G0102?", or ""."""
    near = get_close_matches(_normal(code), list(_pages()), n=1)
    return f", did you mean {near[0]}?" if near else ""


def _normal(code: str) -> str:
    digits = code.upper().removeprefix("G")
    return f"G{digits.zfill(4)}" if digits.isdigit() else code.upper()


@cache
def _pages() -> dict[str, tuple[str, str]]:
    text = (Path(__file__).parent / "pages.md").read_text(encoding="utf-8")
    heads = list(_HEAD.finditer(text))
    ends = [head.start() for head in heads[1:]] + [len(text)]
    return {
        head.group(1): (head.group(2), text[head.end() : end].strip())
        for head, end in zip(heads, ends, strict=True)
    }
