"""Renders the generated files of a model. Only this module may use jinja2."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

import jinja2

from gidl.model import Interface, Model
from gidl.targets.cpp import mock as cpp_mock
from gidl.targets.cpp import view as cpp
from gidl.targets.cpp.lowering import Lowering as CppLowering
from gidl.targets.groups import group
from gidl.targets.lcm import view as lcm
from gidl.targets.line_breaks import laid_out
from gidl.targets.naming import OutputFile, UnsupportedError
from gidl.targets.python import mock as python_mock
from gidl.targets.python import view as python
from gidl.wire.wire_layout import Layout

__all__ = ["LANGUAGES", "UnsupportedError", "render", "render_mock"]

_TARGETS: Mapping[str, Callable[[Model, Layout], Iterator[OutputFile]]] = {
    "cpp": cpp.files,
    "python": python.files,
    "lcm": lcm.files,
}
LANGUAGES = tuple(_TARGETS)


def render(model: Model, layout: Layout, languages: Collection[str] = LANGUAGES) -> dict[str, str]:
    """Returns the generated files, as a map from the path below the output folder to the text.
    Raises UnsupportedError, with the location, for a declaration that a target cannot print. The
    same model always gives the same bytes."""
    texts: dict[str, str] = {}
    for language in LANGUAGES:
        if language not in languages:
            continue
        for output in _TARGETS[language](model, layout):
            template = _environment(output.language).get_template(output.template)
            texts[output.path] = laid_out(template.render(view=output.view), language)
    return texts


def render_mock(
    model: Model, layout: Layout, language: str, interfaces: Sequence[Interface]
) -> str:
    """Returns the text of a mock server for `interfaces`, which must all be declared in one
    file."""
    path = model.file_of(interfaces[0].name)
    view: object
    if language == "cpp":
        view = cpp_mock.mocks_view(CppLowering(model, layout), path, interfaces)
    else:
        view = python_mock.mocks_view(python.lowering(model, layout), path, interfaces)
    suffix = {"cpp": "cpp", "python": "py"}[language]
    template = _environment(language).get_template(f"mock.{suffix}.j2")
    return laid_out(template.render(view=view), language)


@cache
def _environment(language: str) -> jinja2.Environment:
    folder = Path(__file__).parent / language / "templates"
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the output is source code, not HTML
    )
    environment.globals["group"] = group
    return environment
