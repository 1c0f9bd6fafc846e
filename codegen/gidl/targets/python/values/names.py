"""What the builders of views share."""

from __future__ import annotations

from collections.abc import Iterable

from gidl.languages import PYTHON_BUILTINS
from gidl.model import (
    AnyDeclaration,
    Facts,
    Member,
    Type,
)
from gidl.targets.naming import doc_lines
from gidl.targets.python import names
from gidl.targets.python.lower import Lowering

# Bodies call these where parameters stand, which may have their names: `_len` is no such name.
BUILTIN_FUNCTIONS = ("len", "sorted")
# What a body calls something else, and so none of its locals.
LOCAL_WORDS = PYTHON_BUILTINS | {"out", "source", "cls", "self"}


class ValueNames:
    def __init__(self, lowering: Lowering) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._constants = names.Constants()  # one builder makes the views of one file

    def _name(self, declaration: AnyDeclaration) -> str:
        return names.type_name(self._model, declaration.name)


def type_doc(facts: Facts, note: str = "") -> tuple[str, ...]:
    return names.docstring(doc_lines(facts, note))


def type_names(lowering: Lowering, types: Iterable[Type]) -> set[str]:
    """Of the declared types that codecs and hints of these name."""
    used = {name for each in types for name in lowering.imports(each)}
    return {names.type_name(lowering.model, name) for name in used}


def may_be_missing(member: Member) -> bool:
    return member.optional or member.default is not None


def one_line(facts: Facts) -> str:
    return " ".join(doc_lines(facts))
