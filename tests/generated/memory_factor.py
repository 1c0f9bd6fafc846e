"""How much a decoder in C++ may allocate: factor · input + 64 KiB, with a factor for each type.

An element of a sequence takes its `sizeof` for no less than its smallest encoding, and what it
holds itself comes on top. Elements of no width are bounded in number, so they count per sequence.
"""

from __future__ import annotations

from gidl.model import ArrayType, MapType, Model, NamedType, SequenceType, StringType, Struct, Type
from gidl.model import Union as UnionDeclaration
from gidl.targets.cpp.lowering import Lowering
from gidl.wire import wire_layout
from gidl.wire.wire_layout import min_size_of, node_of
from type_values import value_type

MAX_DEPTH = 16
MAX_ZERO_WIDTH = 65_536
COUNT_SIZE = 4
STRING = 2.0  # capacity may be rounded up, but never to twice what lies on the wire
TREE_NODE = 32  # of std::map, beside the entry


class MemoryFactors:
    """Writes the factor of a type as a C++ expression."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._lowering = Lowering(model, wire_layout.build(model))
        self._open: list[str] = []
        self._recursive: set[str] = set()

    def of(self, used: Type) -> str:
        target = self._model.target(used)
        match target:
            case StringType():
                return str(STRING)
            case ArrayType(element):
                return self.of(element)
            case SequenceType(element):
                each = self._per_byte(f"sizeof({self._lowering.type(element)})", element)
                return f"({each} + {self.of(element)})"
            case MapType(key, value):
                size = f"sizeof(std::pair<const {self._lowering.type(key)}, "
                size = f"({TREE_NODE} + {size}{self._lowering.type(value)}>))"
                return f"({self._per_byte(size, key, value)} + {self.of(key)} + {self.of(value)})"
            case NamedType(name):
                return self._named(name)
            case _:
                return "0.0"

    def _per_byte(self, size: str, *parts: Type) -> str:
        least = sum(min_size_of(self._model, node_of(self._model, part)) for part in parts)
        if least == 0:
            return f"{MAX_ZERO_WIDTH // COUNT_SIZE}.0 * double({size})"
        return f"double({size}) / {least}"

    def _named(self, name: str) -> str:
        name = value_type(self._model, name)
        declaration = self._model.find(name)
        if isinstance(declaration, Struct):
            members = [member.type for member in self._model.all_members(declaration)]
        elif isinstance(declaration, UnionDeclaration):
            members = [case.member.type for case in declaration.cases]
        else:
            return "0.0"
        if name in self._open:
            self._recursive.add(name)
            return "0.0"
        self._open.append(name)
        held = sorted({self.of(member) for member in members} - {"0.0"})
        self._open.pop()
        if not held:
            return "0.0"
        times = f"{MAX_DEPTH} * " if name in self._recursive else ""
        return f"({times}std::max<double>({{{', '.join(held)}}}))"
