"""Random sets of .gidl files that include each other."""

from __future__ import annotations

import re
from pathlib import Path as File
from random import Random

import words
from interfaces import Interfaces
from scope import Path, Scopes
from words import written


def write(folder: File, name: str, seed: int) -> list[File]:
    """One to three files in `folder`, each including some of those before it."""
    dice = Random(seed)
    author = Interfaces(dice, Scopes())
    files: list[File] = []
    modules: list[Path] = []
    for index in range(dice.choice((1, 1, 2, 3))):
        file = folder / f"{name}_{'abc'[index]}.gidl"
        # Whatever was declared may be used, so every earlier file is included.
        head = "#pragma once\n" + "".join(f'#include "{earlier.name}"\n' for earlier in files)
        body = "".join(_opened(author, modules) for _ in range(dice.randint(2, 3)))
        # "@optional ::a::T" is an annotation of the name optional::a::T.
        body = re.sub(r"(@[a-z]+) ::", r"\1() ::", body)
        file.write_text(f"{head}\n{body}", encoding="utf-8")
        files.append(file)
    return files


def _opened(author: Interfaces, modules: list[Path]) -> str:
    """A module within modules, new ones or some that are opened again, with declarations."""
    dice = author.dice
    path: Path = ()
    names: list[str] = []
    for depth in range(dice.choice((1, 2, 2, 3))):
        scope = author.scopes.at(path)
        again = [m for m in modules if m[:-1] == path]
        if again and dice.random() < 0.3:
            name = dice.choice(again)[-1]
        else:
            name = _module_name(author, path, depth)
        path = author.scopes.open(path, name)
        if path not in modules:
            modules.append(path)
        names.append(path[-1])
        assert scope.declared
    lines = [author.any(path) for _ in range(dice.randint(2, 5))]
    lines += [author.interface(path) for _ in range(dice.choice((0, 1, 1, 2)))]
    opening = "".join(f"module {written(name)} {{\n" for name in names)
    return f"{opening}{''.join(lines)}{'};' * len(names)}\n"


def _module_name(author: Interfaces, path: Path, depth: int) -> str:
    for _ in range(40):
        name = author.dice.choice(words.MODULES)
        scope = author.scopes.at(path)
        if scope.takes(name):
            return name
    return f"deeper{depth}"
