"""Rule: a type may contain itself only through a sequence, and types are nested at most 16 levels
deep."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import (
    ArrayType,
    MapType,
    Model,
    NamedType,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
)

MAX_DEPTH = 16


def check(model: Model, findings: Findings) -> None:
    walker = _Walker(model, findings)
    for declaration in model.declarations():
        if isinstance(declaration, Struct | Union | Typedef):
            walker.depth(declaration.name)


class _Walker:
    def __init__(self, model: Model, findings: Findings) -> None:
        self._model = model
        self._findings = findings
        self._depths: dict[str, int] = {}
        self._open: list[str] = []

    def depth(self, name: str) -> int:
        """Returns the number of levels of nested structs and unions in the type `name`. The
        elements of sequences do not count as nested."""
        if name in self._depths:
            return self._depths[name]
        if name in self._open:
            self._report_cycle(name)
            return 0
        declaration = self._model.find(name)
        self._open.append(name)
        inner = 0
        match declaration:
            case Struct():
                inner = max((self._of(m.type) for m in declaration.members), default=0)
                if declaration.base is not None:
                    inner = max(inner, self.depth(declaration.base) - 1)
                inner += 1
            case Union():
                inner = 1 + max((self._of(c.member.type) for c in declaration.cases), default=0)
            case Typedef():
                inner = self._of(declaration.type)
        self._open.pop()
        self._depths[name] = inner
        if inner == MAX_DEPTH + 1:
            self._findings.error(
                "G0316",
                declaration.facts.location,
                f"'{declaration.simple_name}' has {inner} levels of nested types, at most "
                f"{MAX_DEPTH} are allowed",
                "remove a level, or put a sequence between two levels",
            )
        return inner

    def _of(self, used: Type) -> int:
        match used:
            case NamedType(name):
                return self.depth(name)
            case ArrayType(element=element):
                return self._of(element)
            case MapType(key, value):
                return max(self._of(key), self._of(value))
            case SequenceType():
                return 0
            case _:
                return 0

    def _report_cycle(self, name: str) -> None:
        cycle = self._open[self._open.index(name) :]
        structs = [n for n in cycle if not isinstance(self._model.find(n), Typedef)]
        first = min(structs or cycle, key=lambda n: self._model.find(n).facts.location)
        start = cycle.index(first)
        ordered = [*cycle[start:], *cycle[:start], first]
        declaration = self._model.find(first)
        self._findings.error(
            "G0314",
            declaration.facts.location,
            f"'{declaration.simple_name}' contains itself: {' -> '.join(ordered)}",
            f"use a sequence in between: sequence<{declaration.simple_name}>",
        )
