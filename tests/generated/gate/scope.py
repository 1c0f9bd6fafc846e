"""Which names are declared where in random IDL, and how a name can be written so that it is found.

IDL compares names without regard to case, and what a scope has used it cannot declare anew.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

import words

Path = tuple[str, ...]


@dataclass
class Scope:
    path: Path
    declared: dict[str, str] = field(default_factory=dict)  # by lower case
    used: set[str] = field(default_factory=set)  # lower case: names of outer scopes, used here
    inner: dict[str, Scope] = field(default_factory=dict)

    def takes(self, name: str) -> bool:
        low = name.lower()
        own = self.path[-1].lower() if self.path else ""
        if self.path == ("gecos",) and low == "objectref":  # a type of our library
            return False
        return low not in self.declared and low not in self.used and low != own

    def declare(self, name: str) -> None:
        self.declared[name.lower()] = name

    def fresh(self, dice: Random, extra: str = "") -> str:
        """A name that nothing here has; often one that differs from another by an underscore."""
        for _ in range(60):
            wanted = words.name(dice)
            if self.declared and dice.random() < 0.12:
                wanted = dice.choice(sorted(self.declared.values())) + "_"
            if self.takes(wanted):
                break
            wanted += extra or str(dice.randint(2, 9))
            if self.takes(wanted):
                break
        else:
            wanted = f"n{len(self.declared)}x"
        self.declare(wanted)
        return wanted


class Scopes:
    """All scopes, as far as they are declared by now."""

    def __init__(self) -> None:
        self.root = Scope(())

    def at(self, path: Path) -> Scope:
        scope = self.root
        for part in path:
            scope = scope.inner[part.lower()]
        return scope

    def open(self, around: Path, name: str) -> Path:
        """A module or interface below `around`: a new one, or again."""
        outer = self.at(around)
        outer.declare(name)
        path = (*around, outer.declared[name.lower()])
        outer.inner.setdefault(name.lower(), Scope(path))
        return path

    def written(self, dice: Random, target: Path, here: Path, *more: Scope) -> str:
        """A name of `target` that means it where it stands in `here` (and in a body, `more`)."""
        absolute = "::" + "::".join(words.written(part) for part in target)
        for start in sorted(range(len(target)), key=lambda _: dice.random()):
            if dice.random() < 0.25:
                return absolute
            parts = target[start:]
            if any(parts[0].lower() in scope.declared for scope in more):
                continue
            if target[:start] == here[:start] and self._found(parts[0], here) == target[:start]:
                self._mark(parts[0], here, more)
                return "::".join(words.written(part) for part in parts)
        return absolute

    def _found(self, first: str, here: Path) -> Path | None:
        """The innermost scope around that has the name."""
        for size in range(len(here), -1, -1):
            if first.lower() in self.at(here[:size]).declared:
                return here[:size]
        return None

    def _mark(self, first: str, here: Path, more: tuple[Scope, ...]) -> None:
        for scope in (*more, self.at(here)):
            if first.lower() not in scope.declared:
                scope.used.add(first.lower())
