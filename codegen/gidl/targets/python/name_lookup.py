"""Names and documentation, which all builders of type views share."""

from __future__ import annotations

from gidl.model import AnyDeclaration, Facts, Member
from gidl.targets.naming import doc_lines
from gidl.targets.python import names
from gidl.targets.python.layout_steps import Lowering


class ValueNames:
    def __init__(self, lowering: Lowering) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout

    def _name(self, declaration: AnyDeclaration) -> str:
        return self._layout.python_names.types[declaration.name].name


def type_doc(facts: Facts, note: str = "") -> tuple[str, ...]:
    return names.docstring(doc_lines(facts, note))


def may_be_missing(member: Member) -> bool:
    return member.optional or member.default is not None
