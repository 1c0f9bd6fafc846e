"""Chooses the base classes of a generated proxy or servant.

Python lists all bases of a class in one order (C3), which keeps the order of each base, and refuses
a class without such an order: `interface C : A, B` where B derives from A. Members are never
overridden, so any order is correct. All classes use the same one: the deepest base first.
"""

from __future__ import annotations

from gidl.model import Interface, Model


def class_bases(model: Model, interface: Interface) -> list[str]:
    """Scoped names of the base classes. The direct bases suffice if Python then orders all bases
    deepest first; otherwise all bases are named."""
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
    """The bases in Python's order (C3). The list ends early if Python would refuse the bases."""
    found: list[str] = []
    while lists := [each for each in lists if each]:
        heads = (each[0] for each in lists)
        head = next((h for h in heads if not any(h in each[1:] for each in lists)), None)
        if head is None:
            break
        found.append(head)
        lists = [each[1:] if each[0] == head else each for each in lists]
    return found
