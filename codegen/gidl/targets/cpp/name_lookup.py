"""The look-up of names, which all builders of type views share."""

from __future__ import annotations

from gidl.model import (
    AnyDeclaration,
)
from gidl.targets.cpp.lowering import Lowering


class ValueNames:
    def __init__(self, lowering: Lowering) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout

    def _name(self, declaration: AnyDeclaration) -> str:
        return self._layout.cpp_names.types[declaration.name].name
