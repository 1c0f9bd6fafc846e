"""Builds the views of enums, bitmasks and bitsets."""

from __future__ import annotations

import textwrap

from gidl.model import (
    Bitmask,
    Bitset,
    EnumDeclaration,
    Primitive,
)
from gidl.names.languages import CPP_BITSET_WORDS, CPP_WORDS
from gidl.names.type_names import escaped
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.name_lookup import ValueNames
from gidl.targets.cpp.statements import block, quoted, rows
from gidl.targets.cpp.type_text import PRIMITIVES
from gidl.targets.cpp.type_views import (
    BitsView,
    EnumeratorView,
    EnumView,
    FieldView,
    MaskView,
    PrintView,
    printed,
)
from gidl.targets.groups import call


class Enums(ValueNames):
    def _enum(self, enum: EnumDeclaration) -> EnumView:
        def word(name: str) -> str:
            return escaped(name, CPP_WORDS)

        return EnumView(
            "enum",
            self._name(enum),
            doc_lines(enum.facts),
            "std::int32_t",
            tuple(
                EnumeratorView(word(e.name), str(e.number), doc_lines(e.facts))
                for e in enum.enumerators
            ),
            "" if enum.default_literal is None else word(enum.default_literal),
            tuple((word(e.name), e.name) for e in enum.enumerators),
            tuple(rows([f"case {e.number}:" for e in enum.enumerators])),
            _known(enum),
        )

    def _mask(self, mask: Bitmask) -> MaskView:
        bits = 64 if mask.bit_bound > 32 else 32
        return MaskView(
            "mask",
            self._name(mask),
            doc_lines(mask.facts),
            f"std::uint{bits}_t",
            f"std::int{bits}_t",
            tuple(
                EnumeratorView(
                    escaped(f.name, CPP_WORDS),
                    f"std::uint{bits}_t{{1}} << {f.position}",
                    doc_lines(f.facts),
                )
                for f in mask.flags
            ),
            f"0x{(1 << mask.bit_bound) - 1:x}U",
        )

    def _bits(self, bitset: Bitset) -> BitsView:
        wide = bitset.bit_size > 32
        unsigned = "std::uint64_t" if wide else "std::uint32_t"
        fields, pack, unpack, check, prints = [], [], [], [], []
        used = 0
        for field in self._model.all_fields(bitset):
            if field.name is None:
                continue
            name = escaped(field.name, CPP_BITSET_WORDS)
            kind = field.type.kind
            mask = (1 << field.width) - 1
            used |= mask << field.position
            initial = " = false" if kind is Primitive.BOOLEAN else " = 0"
            doc = doc_lines(field.facts, f"{field.width} bits")
            fields.append(FieldView(PRIMITIVES[kind], name, initial, doc))
            pack.append(
                f"((static_cast<{unsigned}>({name}) & {unsigned}{{0x{mask:x}U}})"
                f" << {field.position})"
            )
            raw = f"(raw >> {field.position}) & 0x{mask:x}U"
            if kind is Primitive.BOOLEAN:
                unpack.append(f"{name} = ({raw}) != 0;")
            elif kind.is_unsigned or field.width == 8 * kind.size:  # no sign to extend
                unpack.append(f"{name} = static_cast<{PRIMITIVES[kind]}>({raw});")
            else:
                sign = 1 << (field.width - 1)
                wide_type = "std::int64_t"
                unpack.append(
                    f"{name} = static_cast<{PRIMITIVES[kind]}>(({wide_type}{{}} + "
                    f"static_cast<{wide_type}>(({raw}) ^ 0x{sign:x}U)) - {sign});"
                )
            check += self._bits_check(bitset, name, field.name, kind, field.width)
            value = name
            prints.append(PrintView(f"{field.name}=", value, ""))
        unpack.insert(0, f"if ((raw & ~{unsigned}{{0x{used:x}U}}) != 0) return false;")
        return BitsView(
            "bits", self._name(bitset), doc_lines(bitset.facts),
            "std::int64_t" if wide else "std::int32_t", unsigned,
            tuple(fields), tuple(pack), tuple(unpack), tuple(check),
            printed(self._name(bitset), prints),
        )  # fmt: skip

    def _bits_check(
        self, bitset: Bitset, name: str, label: str, kind: Primitive, width: int
    ) -> list[str]:
        if kind is Primitive.BOOLEAN or width == 8 * kind.size:
            return []
        if kind.is_unsigned:
            low, high = 0, (1 << width) - 1
            test = f"value.{name} > {high}U"
        else:
            low, high = -(1 << (width - 1)), (1 << (width - 1)) - 1
            test = f"value.{name} < {low} || value.{name} > {high}"
        text, limits = f"{bitset.simple_name}.{label}", quoted(f"[{low}, {high}]")
        told = call("gecos::wire::out_of_range", quoted(text), f"value.{name}", limits)
        return block(
            f"if ({test})",
            [f"return {told};"],
        )


def _known(enum: EnumDeclaration) -> str:
    """Returns a text such as "no Speed; give one of SLOW, FAST". A long list of enumerators is
    cut."""
    shown = textwrap.shorten(", ".join(e.name for e in enum.enumerators), 50, placeholder=" …")
    return f"no {enum.simple_name}; give one of {shown}"
