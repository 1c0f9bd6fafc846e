"""The keys of gidl.toml. Each key has a check of its value, and an example."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from difflib import get_close_matches
from pathlib import Path

from gidl.cli.explain import lint_rules
from gidl.cli.output import LANGUAGES

DEFINE = re.compile(r"[A-Za-z_]\w*(=[^\n]*)?\Z")
OUTPUTS = "outputs"  # a table with a folder for each language
WIDE = ("utf8",)

_Check = Callable[[object, Path], str]  # returns the mistake in a value, or ""


def wrong_with(keys: tuple[str, ...], value: object, folder: Path) -> tuple[str, str] | None:
    """Returns the mistake in a value and the correction, or None if the value is right. Paths are
    relative to `folder`. `keys` is the path of the key, for example ("roots",) or ("outputs",
    "cpp")."""
    written = ".".join(keys)
    if written == OUTPUTS:
        return f"{OUTPUTS}: a table is expected", 'write for example cpp = "src" below [outputs]'
    if written not in _KEYS:
        near = get_close_matches(written, list(_KEYS), n=1)
        known = f"did you mean '{near[0]}'?" if near else f"known keys are {', '.join(_KEYS)}"
        return f"there is no key '{written}'", known
    check, example = _KEYS[written]
    wrong = check(value, folder)
    return (f"{written}: {wrong}", f"write for example {example}") if wrong else None


def _texts(value: object) -> list[str] | None:
    if isinstance(value, list) and all(isinstance(each, str) and each for each in value):
        return value
    return None


def _folders(value: object, folder: Path) -> str:
    texts = _texts(value)
    if texts is None:
        return "a list of folders is expected"
    gone = [text for text in texts if not (folder / text).is_dir()]
    return f"there is no folder '{gone[0]}' beside gidl.toml" if gone else ""


def _folder(value: object, _: Path) -> str:
    is_name = isinstance(value, str) and value and "\0" not in value
    return "" if is_name else "the name of a folder is expected"


def _defines(value: object, _: Path) -> str:
    texts = _texts(value)
    if texts is None:
        return "a list of constants is expected"
    bad = [text for text in texts if not DEFINE.match(text)]
    return f"'{bad[0]}' is not a constant: write NAME or NAME=VALUE" if bad else ""


def _flag(value: object, _: Path) -> str:
    return "" if isinstance(value, bool) else "true or false is expected"


def _wide(value: object, _: Path) -> str:
    return "" if value in WIDE else f"'{WIDE[0]}' is expected"


def _some_of(known: Callable[[], Collection[str]], what: str) -> _Check:
    def check(value: object, _: Path) -> str:
        texts = _texts(value)
        if texts is None:
            return f"a list of {what} is expected"
        bad = [text for text in texts if text not in known()]
        return f"'{bad[0]}' is not one of {', '.join(sorted(known()))}" if bad else ""

    return check


_KEYS: Mapping[str, tuple[_Check, str]] = {
    "roots": (_folders, 'roots = ["idl"]'),
    "imports": (_folders, 'imports = ["../robcl/idl"]'),
    "languages": (_some_of(lambda: LANGUAGES, "languages"), 'languages = ["cpp", "python"]'),
    "out": (_folder, 'out = "generated"'),
    **{
        f"{OUTPUTS}.{language}": (_folder, f'{language} = "src" below [outputs]')
        for language in LANGUAGES
    },
    "defines": (_defines, 'defines = ["SIMULATED", "RATE=250"]'),
    "wide": (_wide, 'wide = "utf8"'),
    "strict": (_flag, "strict = true"),
    "except": (_some_of(lint_rules, "rules of lint"), 'except = ["G0907"]'),
}
