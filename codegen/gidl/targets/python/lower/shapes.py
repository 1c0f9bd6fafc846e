"""How a type describes itself to gecos.wire.shapes, which JSON is read and written with."""

from __future__ import annotations

from gidl.model import (
    ArrayType,
    Bitmask,
    EnumDeclaration,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from gidl.targets.python import names
from gidl.targets.python.lower.types import CODES, Types, is_octet
from gidl.wire_layout import node_of


class Shapes(Types):
    def shape(self, used: Type, optional: bool = False) -> str:
        text = self._shape(used)
        return f"_shapes.Optional({text})" if optional else text

    def _shape(self, used: Type) -> str:
        target = self.model.target(used)
        match target:
            case PrimitiveType(Primitive.CHAR):
                return "_shapes.Text(1)"
            case PrimitiveType(kind):
                return f'_shapes.Number("{CODES[kind]}")'
            case StringType():
                return "_shapes.Text()"
            case SequenceType(element):
                return self._items(element, None)
            case ArrayType(element, dimensions):
                return self._items(element, dimensions)
            case MapType(key, value):
                return f"_shapes.Entries({self._shape(key)}, {self._shape(value)})"
            case NamedType(name):
                return self._named(name)
        raise AssertionError(target)

    def _items(self, element: Type, dimensions: tuple[int, ...] | None) -> str:
        node = node_of(self.model, element)
        sizes = dimensions or ()
        if is_octet(node) and len(sizes) < 2:
            return f"_shapes.Octets({', '.join(str(size) for size in sizes)})"
        code = self.bulk_code(node)
        if code is not None:
            shape = "".join(f"{size}, " for size in sizes)
            shape = f", ({shape.rstrip() if len(sizes) == 1 else shape[:-2]})" if sizes else ""
            return f'_shapes.Array("{code}"{shape})'
        text = self._shape(element)
        for size in reversed(sizes):
            text = f"_shapes.Items({text}, {size})"
        return text if sizes else f"_shapes.Items({text})"

    def _named(self, name: str) -> str:
        declaration = self.model.find(name)
        mine = names.value_name(self.model, name)
        if not isinstance(declaration, EnumDeclaration | Bitmask):
            return f"_shapes.Value({mine})"
        if isinstance(declaration, EnumDeclaration):
            kind, words = "Enumerators", [e.name for e in declaration.enumerators]
        else:
            kind, words = "Flags", [f.name for f in declaration.flags]
        renamed = ", ".join(
            f'"{names.enumerator(word)}": "{word}"'
            for word in words
            if names.enumerator(word) != word
        )
        return f"_shapes.{kind}({mine}{f', {{{renamed}}}' if renamed else ''})"
