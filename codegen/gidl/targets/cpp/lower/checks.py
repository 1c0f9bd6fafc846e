"""Statements that say why a value must not be sent."""

from __future__ import annotations

from gidl.model import (
    ArrayType,
    Bitset,
    Interface,
    MapType,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
)
from gidl.targets.cpp.lower.statements import (
    block,
    call,
    loop,
)
from gidl.targets.cpp.lower.types import Slot, Types, range_test
from gidl.targets.naming import LocalNames, range_text
from gidl.wire_layout import Layout


class Checks(Types):
    def __init__(self, model: Model, layout: Layout) -> None:
        super().__init__(model, layout)
        self._checked: dict[str, bool] = {}

    def has_checks(self, name: str) -> bool:
        """Whether a value of this type can hold what must not be sent."""
        if name not in self._checked:
            self._checked[name] = False  # while it is asked for: a recursive type adds nothing
            declaration = self.model.find(name)
            match declaration:
                case Struct(maps_to=maps_to) if maps_to is not None and maps_to.cpp:
                    found = False
                case Struct() as struct:
                    found = self.struct_has_checks(struct)
                case Union() | Bitset() | Interface():
                    found = True
                case Typedef(type=target, range=limits):
                    found = self._slot_has_checks(target, limits)
                case _:
                    found = False
            self._checked[name] = found
        return self._checked[name]

    def struct_has_checks(self, struct: Struct) -> bool:
        members = self.model.all_members(struct)
        return any(self._slot_has_checks(m.type, m.range) for m in members)

    def _slot_has_checks(self, used: Type, limits: Range | None) -> bool:
        match used:
            case PrimitiveType():
                return limits is not None
            case StringType() | MapType():
                return True
            case SequenceType(element, bound):
                return bound is not None or self._slot_has_checks(element, None)
            case ArrayType(element):
                return self._slot_has_checks(element, None)
            case NamedType(name):
                return limits is not None or self.has_checks(name)

    def check(self, slot: Slot, local: LocalNames) -> list[str]:
        """Statements that return a text when the value must not be sent."""
        limits = self.limits(slot)
        if slot.optional:
            inner = self._check(slot.type, f"*{slot.expression}", slot.label, limits, local)
            return block(f"if ({slot.expression})", inner) if inner else []
        return self._check(slot.type, slot.expression, slot.label, limits, local)

    def _check(
        self, used: Type, x: str, label: str, limits: Range | None, local: LocalNames
    ) -> list[str]:
        target = self.model.target(used)
        match target:
            case PrimitiveType(kind):
                return self._check_number(kind, x, label, limits)
            case StringType(bound):
                lines = [
                    f'if (!gecos::wire::valid_text({x})) return gecos::wire::bad_text("{label}");'
                ]
                return self._over(x, label, bound, "bytes") + lines
            case SequenceType(element, bound):
                item = local.fresh("item")
                inner = self._check(
                    element, item, label, self.limits(Slot(item, label, element)), local
                )
                return self._over(x, label, bound, "elements") + loop(item, x, inner)
            case ArrayType(element, dimensions):
                item = local.fresh("item")
                inner = self._check(element, item, label, None, local)
                for _ in dimensions[1:]:
                    outer = local.fresh("row")
                    inner, item = loop(item, outer, inner), outer
                return loop(item, x, inner)
            case MapType(key, value, bound):
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                inner = [
                    *self._check(key, key_name, label, None, local),
                    *self._check(value, value_name, label, None, local),
                ]
                head = f"for (const auto& [{key_name}, {value_name}] : {x})"
                lines = block(head, inner) if inner else []
                return self._over(x, label, bound, "entries") + lines
            case NamedType(name):
                if not self.has_checks(name):
                    return []
                why = local.fresh("why")
                return [f"if (auto {why} = gecos_violation({x}); !{why}.empty()) return {why};"]

    def _check_number(self, kind: Primitive, x: str, label: str, limits: Range | None) -> list[str]:
        test = range_test(x, kind, limits)
        if not test or limits is None:
            return []
        wide = "double" if kind.is_floating else "long long"
        if kind.is_unsigned:
            wide = "unsigned long long"
        cast = x if kind is Primitive.DOUBLE else f"static_cast<{wide}>({x})"
        return [
            f"if (!{test}) {{",
            f'  return gecos::wire::out_of_range("{label}", {cast}, "{range_text(limits)}");',
            "}",
        ]

    @staticmethod
    def _over(x: str, label: str, bound: int | None, what: str) -> list[str]:
        if bound is None:
            return []
        size = call(x, "size()")
        return [
            f"if ({size} > {bound}) {{",
            f'  return gecos::wire::over_bound("{label}", {size}, {bound}, "{what}");',
            "}",
        ]
