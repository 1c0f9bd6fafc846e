"""Chooses the base classes of a generated proxy or servant.

Python puts all bases of a class in one order, by the algorithm C3, which keeps the order that each
base already has. Python refuses a class for which no such order exists: for example the class of
`interface C : A, B` where B derives from A. Members are never overridden, so any order is correct.
All generated classes use the same order: the deepest base first.
"""

from __future__ import annotations

from gidl.model import Interface, Model


def class_bases(model: Model, interface: Interface) -> list[str]:
    """Returns the scoped names of the base classes. These are the direct bases if Python then
    orders all bases from the deepest to the least deep. Otherwise these are all bases, in that
    order."""
    wanted = _ordered(model, interface.all_bases)
    inherited = {name for base in interface.bases for name in model.interface(base).all_bases}
    own = _ordered(model, [name for name in interface.bases if name not in inherited])
    lists = [[name, *_ordered(model, model.interface(name).all_bases)] for name in own]
    return own if _merged([*lists, own]) == wanted else wanted


def _ordered(model: Model, names: tuple[str, ...] | list[str]) -> list[str]:
    return sorted(names, key=lambda name: (-_depth(model, name), name))


def _depth(model: Model, name: str) -> int:
    return max((1 + _depth(model, base) for base in model.interface(name).bases), default=0)


def _merged(lists: list[list[str]]) -> list[str]:
    """Returns the bases in the order of Python (C3). The list ends early if Python would refuse the
    bases."""
    found: list[str] = []
    while lists := [each for each in lists if each]:
        heads = (each[0] for each in lists)
        head = next((h for h in heads if not any(h in each[1:] for each in lists)), None)
        if head is None:
            break
        found.append(head)
        lists = [each[1:] if each[0] == head else each for each in lists]
    return found
