"""Prints the files of a model. The one place that knows jinja2."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from pathlib import Path

import jinja2

from gidl.model import Model
from gidl.targets.cpp import view as cpp
from gidl.targets.layout import laid_out
from gidl.targets.lcm import view as lcm
from gidl.targets.naming import OutputFile, UnsupportedError
from gidl.targets.python import view as python
from gidl.wire_layout import Layout

__all__ = ["LANGUAGES", "UnsupportedError", "render"]

_TARGETS: Mapping[str, Callable[[Model, Layout], Iterator[OutputFile]]] = {
    "cpp": cpp.files,
    "python": python.files,
    "lcm": lcm.files,
}
LANGUAGES = tuple(_TARGETS)


def render(model: Model, layout: Layout, languages: Collection[str] = LANGUAGES) -> dict[str, str]:
    """Path below the output folder -> text, for every file that was asked for. Raises
    UnsupportedError, naming the place, for what a target cannot print. The same model gives the
    same bytes."""
    texts: dict[str, str] = {}
    for language in LANGUAGES:
        if language not in languages:
            continue
        for output in _TARGETS[language](model, layout):
            template = _environment(output.language).get_template(output.template)
            texts[output.path] = laid_out(template.render(view=output.view), language)
    return texts


@cache
def _environment(language: str) -> jinja2.Environment:
    folder = Path(__file__).parent / "targets" / language / "templates"
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # source code, not HTML
    )
