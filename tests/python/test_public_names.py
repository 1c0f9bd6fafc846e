from __future__ import annotations

import ast
from pathlib import Path

import gecos
import pytest


def names_for_type_checkers() -> dict[str, str]:
    """Name to module, as the `if TYPE_CHECKING` block of the package imports them."""
    source = Path(gecos.__file__).read_text(encoding="utf-8")
    (block,) = (node for node in ast.parse(source).body if isinstance(node, ast.If))
    found = {}
    for statement in block.body:
        assert isinstance(statement, ast.ImportFrom)
        assert statement.module is not None
        for alias in statement.names:
            assert alias.asname == alias.name, "`as` makes it public under mypy --strict"
            found[alias.name] = statement.module.removeprefix("gecos.")
    return found


def test_type_checkers_and_programs_see_the_same_names() -> None:
    assert names_for_type_checkers() == gecos._HOME


def test_every_public_name_can_be_used() -> None:
    for name in dir(gecos):
        assert getattr(gecos, name).__name__ == name


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'gecos' has no attribute 'Roboter'"):
        gecos.Roboter  # noqa: B018
