"""Builds Python types from declarations, by the same functions of `gecos.wire.layout` that
generated code uses. Therefore the codec, the ranges and the JSON of these types are the same as
those of generated types.

Only sequences and arrays of numbers differ: they are lists, because importing numpy takes long.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, make_dataclass
from enum import IntEnum, IntFlag
from math import prod
from typing import Any

from gecos.dynamic_client.json_object import Malformed
from gecos.dynamic_client.model import (
    Bitmask,
    Bitset,
    Enumeration,
    Limits,
    Model,
    Operation,
    Struct,
    Union,
    Value,
)
from gecos.dynamic_client.names import (
    BITSET_WORDS,
    ENUM_WORDS,
    EXCEPTION_WORDS,
    STRUCT_WORDS,
    escaped,
    member_name,
    simple,
)
from gecos.dynamic_client.plain import PlainMap
from gecos.dynamic_client.type_text import CODES, Type
from gecos.errors import DeclaredError
from gecos.wire import layout
from gecos.wire.codes import MAX_COUNT, MAX_TEXT, MAX_ZERO_WIDTH
from gecos.wire.errors import EncodeError, JsonError
from gecos.wire.kinds import Later, Ranged, kind_of
from gecos.wire.kinds import Limits as WireLimits

_MAX_LEVELS = 64  # levels of types inside each other, including sequences
_LARGEST: dict[str, int | float] = {
    **dict.fromkeys("bBhHiIq", (1 << 63) - 1),
    "Q": (1 << 64) - 1,
    "f": 3.4e38,
    "d": 1.7e308,
}
"""The greatest absolute value that a limit of a range may have. The keys are the format characters
of the module `struct` for the types of numbers."""
_FLOATING = ("float", "double")
_ZEROS = {"boolean": False, "char": "\0", "float": 0.0, "double": 0.0}


class Types:
    """The Python types of one model. Each type is built when it is first used."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._classes: dict[str, Any] = {}
        self._open: list[str] = []
        self._levels = 0

    # -- values ------------------------------------------------------------------------------------

    def step(self, value: Value) -> layout.Step:
        """Returns the layout step of a member, parameter or result."""
        found = self._bare(value.use, value.limits, value.unit)
        if value.optional:
            found = layout.optional(found)
        return layout.secret(found) if value.secret else found

    def default(self, value: Value) -> Any:
        """Returns the value that stands for a missing member or argument. @pre
        `value.may_be_missing`"""
        return None if value.optional else self._literal(value.default, value.use, value.name)

    def _bare(self, use: Type, limits: Limits | None, unit: str = "") -> layout.Step:
        use, limits = self._model.resolved(use, limits)
        if self._levels == _MAX_LEVELS:
            raise Malformed(f"more than {_MAX_LEVELS} levels of types")
        self._levels += 1
        try:
            return self._resolved(use, limits, unit)
        finally:
            self._levels -= 1

    def _resolved(self, use: Type, limits: Limits | None, unit: str) -> layout.Step:
        match use.kind:
            case "primitive":
                return _number(use.name, limits, unit)
            case "string":
                return layout.text(MAX_TEXT if use.bound is None else use.bound)
            case "sequence":
                most = MAX_COUNT if use.bound is None else use.bound
                octets = self._octet_limits(use, limits)
                if octets is not None:
                    return layout.octets(most, *octets, unit)
                return layout.items(self._bare(use.inner[0], limits, unit), most)
            case "array":
                octets = self._octet_limits(use, limits)
                if octets is not None and len(use.sizes) == 1:
                    return layout.fixed_octets(use.sizes[0], *octets, unit)
                step = self._bare(use.inner[0], limits, unit)
                _check_size(step, prod(use.sizes))
                for size in reversed(use.sizes):
                    step = layout.fixed_items(step, size)
                return step
            case "map":
                self._check_key(use.inner[0])
                key, value = (self._bare(each, None) for each in use.inner)
                most = MAX_COUNT if use.bound is None else use.bound
                return PlainMap(kind_of(key), kind_of(value), most)
            case _:
                named: layout.Step = self.named(use.name)
                return named

    def _check_key(self, key: Type) -> None:
        """Enforces the rule of `gidl.rules.maps`: keys are values that compare exactly."""
        use, _ = self._model.resolved(key)
        if use.kind == "string" or (use.kind == "primitive" and use.name not in _FLOATING):
            return
        if not isinstance(self._model.types.get(use.name), Enumeration):
            raise Malformed(f"{key.name or key.kind} cannot be the key of a map")

    def _octet_limits(self, use: Type, limits: Limits | None) -> tuple[Any, Any] | None:
        """Returns the limits of the elements of `use` if they are octets, which are kept in a bytes
        object."""
        element, narrowed = self._model.resolved(use.inner[0], limits)
        if element.kind != "primitive" or element.name != "octet":
            return None
        return (None, None) if narrowed is None else (narrowed.low, narrowed.high)

    def _literal(self, literal: Any, use: Type, place: str) -> Any:
        """Returns the Python value of a default, or of a label of a union."""
        use, limits = self._model.resolved(use)
        kind = kind_of(self._bare(use, limits))
        try:
            value = kind.made(self._model.plain_literal(literal, use), place)
            kind.put(value, [], place)
        except (JsonError, EncodeError) as error:
            raise Malformed(f"the value {literal!r} of {place} is not valid: {error.why}") from None
        return value

    def _initial(self, value: Value) -> Any:
        """Returns the dataclass field of a member. The field has the default value, or a function
        that makes it."""
        if value.may_be_missing:
            return field(default=self.default(value))
        made = self._zero(value.use)
        return field(default_factory=made) if callable(made) else field(default=made)

    def _zero(self, use: Type) -> Any:
        """Returns the value that a member of a type has before it is set, for example 0 or "". For
        a type with mutable values, returns a function that makes this value."""
        use, _ = self._model.resolved(use)
        match use.kind:
            case "primitive":
                return _ZEROS.get(use.name, 0)
            case "string":
                return ""
            case "sequence":
                return list if self._octet_limits(use, None) is None else b""
            case "map":
                return dict
            case "array":
                return self._zero_array(use)
        declared = self._model.types.get(use.name)
        if isinstance(declared, Enumeration):
            return self.named(use.name)[escaped(declared.initial, ENUM_WORDS)]
        if isinstance(declared, Bitmask):
            return self.named(use.name)(0)
        self.named(use.name)
        return lambda: self._class(use.name)()

    def _zero_array(self, use: Type) -> Any:
        if self._octet_limits(use, None) is not None and len(use.sizes) == 1:
            return bytes(use.sizes[0])
        inner = self._zero(use.inner[0])

        def made(sizes: tuple[int, ...]) -> Any:
            if sizes:
                return [made(sizes[1:]) for _ in range(sizes[0])]
            return inner() if callable(inner) else inner

        return lambda: made(use.sizes)

    # -- declarations ------------------------------------------------------------------------------

    def named(self, name: str) -> Any:
        """Returns the class of a declared type. While the class is still being built, returns a
        function that later returns the class."""
        if name in self._open:
            return lambda: self._classes[name]
        return self._class(name)

    def _class(self, name: str) -> Any:
        if name not in self._classes:
            self._open.append(name)
            try:
                self._classes[name] = self._built(name)
            finally:
                self._open.pop()
        return self._classes[name]

    def _built(self, name: str) -> Any:
        match self._model.types.get(name):
            case Struct() as declared:
                return self._struct(declared)
            case Union() as declared:
                return self._union(declared)
            case Enumeration() as declared:
                return self._enumeration(declared)
            case Bitmask() as declared:
                return self._bitmask(declared)
            case Bitset() as declared:
                return self._bitset(declared)
            case _:
                return _object_reference()

    def _struct(self, declared: Struct) -> Any:
        members = self._model.all_members(declared)
        attributes = self._attributes(members, declared.is_exception)
        terms: dict[str, Any] = {
            "missing": _missing(members) if declared.appendable else 0,
            "open": declared.appendable,
            "label": simple(declared.name),
            "names": _renamed(attributes, members),
        }
        steps = [self.step(each) for each in members]
        bases = (layout.Struct, DeclaredError) if declared.is_exception else (layout.Struct,)
        kind = self._dataclass(declared, attributes, map(self._initial, members), bases)
        if declared.is_exception:
            units = {each.name: each.unit for each in members if each.unit and not each.secret}
            tell = layout.exception(
                declared.name, declared.fingerprint, *steps, units=units, **terms
            )
        else:
            deep = self._reaches_itself(declared.name)
            tell = layout.struct(declared.fingerprint, *steps, deep=deep, **terms)
        return tell(kind)

    def result(self, operation: Operation) -> Any:
        """Returns the class for the result of an operation with several results."""
        values = operation.outputs
        attributes = self._attributes(values, False)
        name = f"{self._model.class_name(operation.interface)}_{operation.name}_result"
        kind = make_dataclass(
            name,
            [(a, Any, self._initial(v)) for a, v in zip(attributes, values, strict=True)],
            bases=(layout.Encoded,),
            namespace={"__doc__": f"The results of {operation.name}.", "__module__": __name__},
            slots=True,
        )
        steps = [self.step(each) for each in values]
        missing, names = _missing(values), _renamed(attributes, values)
        return layout.result(*steps, missing=missing, names=names)(kind)

    def _union(self, declared: Union) -> Any:
        use, _ = self._model.resolved(declared.discriminator)
        if not self._selects(use):
            raise Malformed(f"the discriminator of type {declared.name} is not a whole number")
        tag = self._bare(use, None)
        place = simple(declared.name)
        arms = [
            layout.arm(
                case.member.name,
                layout.secret(step) if case.member.secret else step,
                *(self._literal(label, use, place) for label in case.labels),
            )
            for case in declared.cases
            for step in [self._bare(case.member.use, case.member.limits, case.member.unit)]
        ]
        fields = [field(default=self._zero(use)), field(default=None)]
        kind = self._dataclass(declared, ["tag", "value"], iter(fields), (layout.Union,))
        deep = self._reaches_itself(declared.name)
        return layout.union(
            declared.fingerprint, tag, *arms, open=declared.appendable, deep=deep, label=place
        )(kind)

    def _selects(self, use: Type) -> bool:
        if use.kind == "primitive":
            return use.name not in _FLOATING
        declared = self._model.types.get(use.name) if use.kind == "named" else None
        return isinstance(declared, Enumeration | Bitmask)

    def _enumeration(self, declared: Enumeration) -> Any:
        names = {escaped(name, ENUM_WORDS): name for name, _ in declared.enumerators}
        numbers = [number for _, number in declared.enumerators]
        kind = IntEnum(  # type: ignore[misc]  # the enumerators are known at run time only
            self._model.class_name(declared.name),
            list(zip(names, numbers, strict=True)),
            module=__name__,
        )
        unknown = None if declared.otherwise is None else escaped(declared.otherwise, ENUM_WORDS)
        return layout.enumeration("q" if declared.bits > 32 else "i", unknown, names)(kind)

    def _bitmask(self, declared: Bitmask) -> Any:
        names = {escaped(name, ENUM_WORDS): name for name, _ in declared.flags}
        numbers = [1 << position for _, position in declared.flags]
        kind = IntFlag(  # type: ignore[misc]
            self._model.class_name(declared.name),
            list(zip(names, numbers, strict=True)),
            module=__name__,
        )
        return layout.flags("Q" if declared.bits > 32 else "I", declared.bits, names)(kind)

    def _bitset(self, declared: Bitset) -> Any:
        named = [each for each in self._model.all_fields(declared) if each[0]]
        attributes = [member_name(name, BITSET_WORDS) for name, *_ in named]
        fields = (field(default=False if type == "boolean" else 0) for *_, type in named)
        kind = self._dataclass(declared, attributes, fields, (layout.Bits,))
        members = [(position, width, CODES[type]) for _, position, width, type in named]
        names = dict(zip(attributes, (name for name, *_ in named), strict=True))
        code = "Q" if declared.bits > 32 else "I"
        return layout.bits(code, *members, label=simple(declared.name), names=names)(kind)

    def _dataclass(
        self,
        declared: Struct | Union | Bitset,
        attributes: list[str],
        fields: Iterator[Any],
        bases: tuple[type, ...],
    ) -> Any:
        return make_dataclass(
            self._model.class_name(declared.name),
            [(name, Any, each) for name, each in zip(attributes, fields, strict=True)],
            bases=bases,
            namespace={"__doc__": declared.doc or declared.name, "__module__": __name__},
            eq=DeclaredError not in bases,
            slots=True,
        )

    def _attributes(self, members: tuple[Value, ...], is_exception: bool) -> list[str]:
        words = EXCEPTION_WORDS if is_exception else STRUCT_WORDS
        words |= {self._model.class_name(n) for each in members for n in each.use.named()}
        return [member_name(each.name, words) for each in members]

    def _reaches_itself(self, name: str) -> bool:
        """Returns whether a value of the type can contain another value of the same type."""
        seen, waiting = set[str](), [name]
        while waiting:
            declared = self._model.types.get(waiting.pop())
            if declared is None:
                continue
            for inner in {n for use in self._model.direct_uses(declared) for n in use.named()}:
                if inner == name:
                    return True
                if inner not in seen:
                    seen.add(inner)
                    waiting.append(inner)
        return False


def _number(name: str, limits: Limits | None, unit: str) -> layout.Step:
    code = CODES[name]
    if name == "char":
        return layout.char()
    if limits is None or name == "boolean":
        return code
    for limit in (limits.low, limits.high):
        if limit is not None and not -_LARGEST[code] <= limit <= _LARGEST[code]:
            raise Malformed(f"the range {limits} is larger than that of the type {name}")
    binding = WireLimits(code, limits.low, limits.high).effective(code) != (None, None)
    return Ranged(code, limits.low, limits.high, unit) if binding else code


def _check_size(element: layout.Step, count: int) -> None:
    """Refuses an array of very many elements that take no bytes, because the size of a message does
    not limit the number of such elements."""
    kind = kind_of(element)
    # The kind Later stands for a type that contains itself. Such a type contains a sequence of its
    # own values, and the count of this sequence takes bytes.
    takes_bytes = isinstance(kind, Later) or kind.least
    if count > MAX_ZERO_WIDTH and not takes_bytes:
        raise Malformed(
            f"an array has {count} values that take no bytes; at most {MAX_ZERO_WIDTH} are read"
        )


def _missing(values: tuple[Value, ...]) -> int:
    """Returns how many of the last values an older writer may leave out."""
    count = 0
    while count < len(values) and values[-1 - count].may_be_missing:
        count += 1
    return count


def _renamed(attributes: list[str], values: tuple[Value, ...]) -> dict[str, str]:
    return dict(zip(attributes, (each.name for each in values), strict=True))


def _object_reference() -> Any:
    from gecos_idl.object_ref_types import ObjectRef

    return ObjectRef
