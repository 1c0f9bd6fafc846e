"""Chooses the base classes of a generated proxy or servant.

Python computes one order of all bases of a class by the algorithm C3. This order must contain the
bases of each base in the order that Python computed for that base. Python refuses a class for which
no such order exists: for example the class of `interface C : A, B` if B derives from A. Members are
never overridden, so any order is correct. All generated classes use the same order: the interface
with the longest chain of bases comes first.
"""

from __future__ import annotations

from gidl.model import Interface, Model


def class_bases(model: Model, interface: Interface) -> list[str]:
    """Returns the scoped names of the interfaces whose classes become the base classes of the class
    of `interface`.

    All generated classes search their bases in one order: that of `_ordered`. If Python computes
    this order from the direct bases alone, the list has only the direct bases; otherwise it has all
    bases, in this order."""
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
    """Returns the order that Python (C3) would compute from the orders `lists`. If Python would
    refuse the class, the result lacks some bases."""
    found: list[str] = []
    while lists := [each for each in lists if each]:
        heads = (each[0] for each in lists)
        head = next((h for h in heads if not any(h in each[1:] for each in lists)), None)
        if head is None:
            break
        found.append(head)
        lists = [each[1:] if each[0] == head else each for each in lists]
    return found
