"""Interfaces of random files: operations, attributes, streams, events, types inside, bases."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

from author import HEAVIEST_MEMBER, Number, Used
from declarations import Declarations
from scope import Path, Scope, Scopes
from words import comment, written


@dataclass
class Made:
    """An interface: its bases, and what it and they declare."""

    path: Path
    bases: list[Made] = field(default_factory=list)
    own: dict[str, str] = field(default_factory=dict)

    def with_bases(self) -> list[Made]:
        found: list[Made] = []
        for base in self.bases:
            found += [each for each in base.with_bases() if each not in found]
        return [*found, self]

    def names(self) -> dict[str, str]:
        return {low: name for each in self.with_bases() for low, name in each.own.items()}


class Interfaces(Declarations):
    def __init__(self, dice: Random, scopes: Scopes) -> None:
        super().__init__(dice, scopes)
        self.made: list[Made] = []

    def interface(self, here: Path) -> str:
        bases = self._bases()
        above = [self.scopes.written(self.dice, base.path, here) for base in bases]
        name = self.fresh(here)
        path = self.scopes.open(here, name)
        made = Made(path, bases)
        scope = self.scopes.at(path)
        inherited = made.names()
        scope.declared.update(inherited)
        head = comment(self.dice)
        if self.once_in(3):
            head += "interface " + written(name) + ";\n"
        self.interfaces.append(path)
        lines = [self.any(path) for _ in range(self.dice.choice((0, 0, 1, 2)))]
        for _ in range(self.dice.randint(1, 4)):
            lines.append(comment(self.dice) + self._call(path, scope))
        made.own = {low: n for low, n in scope.declared.items() if low not in inherited}
        self.made.append(made)
        body = "".join(f"  {line}" for line in lines)
        after = f" : {', '.join(above)}" if above else ""
        return f"{head}interface {written(name)}{after} {{\n{body}}};\n"

    def _bases(self) -> list[Made]:
        """None, one, or several that share no name but by a common base."""
        bases: list[Made] = []
        for candidate in self.dice.sample(self.made, min(len(self.made), self.dice.randint(0, 3))):
            lines = [made for base in bases for made in base.with_bases()]
            other = {
                low for made in lines if made not in candidate.with_bases() for low in made.own
            }
            fresh = [made for made in candidate.with_bases() if made not in lines]
            if candidate in lines or any(base in candidate.with_bases() for base in bases):
                continue
            if not any(low in other for made in fresh for low in made.own):
                bases.append(candidate)
        return bases

    def _call(self, here: Path, scope: Scope) -> str:
        if self.once_in(3):
            return self._attribute(here, scope)
        if self.once_in(6):
            return self._event(here, scope)
        return self._operation(here, scope)

    def _value(self, here: Path, depth: int, *more: Scope) -> Used:
        for _ in range(8):
            used = self.use(here, depth, *more)
            if used.weight <= HEAVIEST_MEMBER:
                return used
        return Used("double", 1, Number("double"), True)

    def _operation(self, here: Path, scope: Scope) -> str:
        used = self._value(here, 2) if self.once_in(1.6) else None
        result = "void" if used is None else used.text
        marks = self.dice.choice(("", "@actor ", "@sensor ", "@master "))
        if used is not None:
            marks += self.limits(used.number)[0]
            marks += "@secret " if used.is_string and self.once_in(2) else ""
            marks += "@optional " if self.once_in(8) else ""
        marks += "@actor " * (not marks.startswith("@"))
        if self.once_in(8) and "@sensor" not in marks:
            marks += "@cancelable "
        raises = self.dice.sample(self.exceptions, min(len(self.exceptions), 2))
        inside = Scope((*here, "()"))
        parameters = [
            self._parameter(here, inside) for _ in range(self.dice.choice((0, 1, 1, 2, 3, 4)))
        ]
        after = ""
        if raises and self.once_in(3):
            after = (
                f" raises ({', '.join(self.scopes.written(self.dice, r, here) for r in raises)})"
            )
        name = written(scope.fresh(self.dice))
        return f"{marks}{result} {name}({', '.join(parameters)}){after};\n"

    def _event(self, here: Path, scope: Scope) -> str:
        marks = self.dice.choice(("@sensor ", "@actor "))
        inside = Scope((*here, "()"))
        count = self.dice.choice((0, 1, 1, 2, 3))
        parameters = [self._parameter(here, inside, ("in",)) for _ in range(count)]
        name = written(scope.fresh(self.dice))
        return f"{marks}@event oneway void {name}({', '.join(parameters)});\n"

    def _parameter(
        self,
        here: Path,
        inside: Scope,
        ways: tuple[str, ...] = ("in", "in", "in", "out", "inout"),
    ) -> str:
        used = self._value(here, 1, inside)
        way = self.dice.choice(ways)
        marks = self.limits(used.number)[0]
        marks += "@secret " if used.is_string and self.once_in(2) else ""
        marks += "@optional " if self.once_in(6) else ""
        return f"{marks}{way} {used.text} {written(inside.fresh(self.dice))}"

    def _attribute(self, here: Path, scope: Scope) -> str:
        used = self._value(here, 2)
        marks = self.dice.choice(("@sensor ", "@actor "))
        marks += self.limits(used.number)[0]
        marks += "@secret " if used.is_string and self.once_in(2) else ""
        marks += "@optional " if self.once_in(8) else ""
        if self.once_in(3):
            marks += '@stream(rate="10Hz") '
        readonly = "readonly " if self.once_in(2) else ""
        name = written(scope.fresh(self.dice))
        return f"{marks}{readonly}attribute {used.text} {name};\n"
