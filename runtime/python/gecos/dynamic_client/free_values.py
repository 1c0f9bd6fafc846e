"""Checks that a few bytes from a server cannot be decoded into very many values."""

from __future__ import annotations

from math import prod

from gecos.dynamic_client.json_object import Malformed
from gecos.dynamic_client.model import Declaration, Model, Struct, Typedef, Union
from gecos.dynamic_client.type_text import Type
from gecos.wire.codes import MAX_ZERO_WIDTH

_MAX_FREE = 1 << 22
_MAX_OPEN = 64  # levels of types, including sequences


def check_free_values(model: Model) -> None:
    """Raises `Malformed` if one value of a type may contain more than `_MAX_FREE` values whose
    encoding has no bytes, or if the parameters and the result of one call may together contain
    more. The values without bytes are empty structs, and arrays and structs of empty structs.

    @pre no type contains itself other than through a sequence
    """
    counter = _Counter(model)
    for name in model.types:
        counter.named(name)
    for member in model.members:
        values = [*member.parameters, *([] if member.result is None else [member.result])]
        free = sum(counter.used(each.use)[1] for each in values)
        _limit(free, f"{member.interface}::{member.name}")


class _Counter:
    """Finds for each type whether its values take no bytes, and how many values without bytes one
    value may contain. If the elements of a sequence or array take bytes, only one element is
    counted, because the size of the message limits the number of elements."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._known: dict[str, tuple[bool, int]] = {}
        self._open: list[str] = []

    def named(self, name: str) -> tuple[bool, int]:
        if name in self._known or name not in self._model.types:
            return self._known.get(name, (False, 0))
        if name in self._open:  # a type that contains itself through a sequence takes bytes
            return False, 0
        if len(self._open) == _MAX_OPEN:
            raise Malformed(f"type {self._open[0]} has more than {_MAX_OPEN} levels of types")
        self._open.append(name)
        empty, free = self._declared(self._model.types[name])
        self._open.pop()
        _limit(free, f"type {name}")
        self._known[name] = empty, free
        return empty, free

    def _declared(self, declared: Declaration) -> tuple[bool, int]:
        inside = [self.used(use) for use in self._model.direct_uses(declared)]
        free = [count for _, count in inside]
        if isinstance(declared, Typedef):
            return inside[0]
        if isinstance(declared, Union):
            return False, max(free)
        if isinstance(declared, Struct):
            optional = any(each.optional for each in self._model.all_members(declared))
            empty = all(each for each, _ in inside) and not (optional or declared.appendable)
            return empty, sum(free) + empty
        return False, 0

    def used(self, use: Type) -> tuple[bool, int]:
        if use.kind == "named":
            return self.named(use.name)
        if not use.inner:
            return False, 0
        empty, free = self.used(use.inner[-1])
        if not empty:
            return False, free
        if use.kind == "array":
            return True, 1 + free * prod(use.sizes)
        if use.kind == "sequence":
            most = MAX_ZERO_WIDTH if use.bound is None else min(use.bound, MAX_ZERO_WIDTH)
            return False, free * most
        return False, free  # the keys of a map take bytes


def _limit(free: int, place: str) -> None:
    if free > _MAX_FREE:
        raise Malformed(
            f"{place} would have more than {_MAX_FREE} values that take no bytes (empty structs)"
        )
