"""Checks that the values of a served model are neither infinite nor absurdly large."""

from __future__ import annotations

from math import prod

from gecos.dynamic_client.json_object import Malformed
from gecos.dynamic_client.model import Declaration, Model, Struct, Typedef, Union
from gecos.dynamic_client.type_text import Type

_MAX_DEPTH = 16  # levels of structs and unions without a sequence in between, as in gidl
_MAX_OPEN = 64  # levels of structs, unions and typedefs without a sequence in between
_MAX_SIZE = 1 << 22  # numbers, texts and other values in the smallest value of a type
_OCTETS = 64  # a bytes object needs little memory, so this number of octets counts as one value
_REFERENCE = (1, 4)


def check_nesting(model: Model) -> None:
    """Raises `Malformed` if a type contains itself other than through a sequence, if types are
    nested too deep, or if the smallest value of a type is too large."""
    walker = _Walker(model)
    for name in model.types:
        walker.named(name)


class _Walker:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._known: dict[str, tuple[int, int]] = {}
        self._open: list[str] = []

    def named(self, name: str) -> tuple[int, int]:
        """Returns how many levels of types the type `name` has, and how many values its smallest
        value consists of."""
        if name in self._known or name not in self._model.types:
            return self._known.get(name, _REFERENCE)
        if name in self._open:
            raise Malformed(f"type {name} contains itself other than through a sequence")
        if len(self._open) == _MAX_OPEN:
            raise Malformed(f"type {self._open[0]} has more than {_MAX_OPEN} levels of types")
        self._open.append(name)
        depth, size = self._declared(self._model.types[name])
        self._open.pop()
        if depth > _MAX_DEPTH:
            raise Malformed(f"type {name} has more than {_MAX_DEPTH} levels of nested types")
        if size > _MAX_SIZE:
            raise Malformed(f"each value of type {name} would have more than {_MAX_SIZE} members")
        self._known[name] = depth, size
        return depth, size

    def _declared(self, declared: Declaration) -> tuple[int, int]:
        inside = [self._used(use) for use in self._model.direct_uses(declared)]
        depth = max((depth for depth, _ in inside), default=0)
        if isinstance(declared, Typedef):
            return inside[0]
        if isinstance(declared, Union):
            return depth + 1, 1
        if isinstance(declared, Struct):
            members = zip(self._model.all_members(declared), inside, strict=True)
            sizes = (1 if member.optional else size for member, (_, size) in members)
            return depth + 1, 1 + sum(sizes)
        return 0, 1

    def _used(self, use: Type) -> tuple[int, int]:
        if use.kind == "named":
            return self.named(use.name)
        if use.kind == "map":
            return max(self._used(each)[0] for each in use.inner), 1
        if use.kind == "array":
            depth, size = self._used(use.inner[0])
            element, _ = self._model.resolved(use.inner[0])
            octets = element.kind == "primitive" and element.name == "octet"
            return depth, 1 + size * prod(use.sizes) // (_OCTETS if octets else 1)
        return 0, 1
