"""Hashes by which client and server check that they have the same interface.

A hash is the first 8 bytes of the SHA-256 of a canonical text, read as an unsigned big-endian
number.

The *operation hash* covers the name, direction and type of every value on the wire, the exceptions
and `oneway`. Compatible edits do not change it. The operation hash leaves out defaulted or optional
parameters at the end of an operation, and defaulted or optional members at the end of an appendable
struct. It also leaves out the enumerators of an enum with a default literal. A client and a server
with equal operation hashes can call each other.

The *interface hash* covers the whole interface and its bases, and leaves out nothing. If client and
server have equal interface hashes, they compare nothing more. Otherwise the operation hashes
decide.

Neither hash covers documentation, units, access or quality; the server enforces access.
"""

from __future__ import annotations

import hashlib

from gidl.model import (
    ArrayType,
    Attribute,
    Bitmask,
    Bitset,
    EnumDeclaration,
    EnumValue,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Operation,
    Parameter,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    Value,
)
from gidl.wire.function_codes import hashed_name, member_name


def hash64(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode("utf-8")).digest()[:8], "big")


def operation_hash(model: Model, operation: Operation) -> int:
    return hash64(_Writer(model, whole=False).operation(operation))


def attribute_hash(model: Model, attribute: Attribute) -> int:
    if attribute.event is not None:
        return operation_hash(model, attribute.event)
    return hash64(_Writer(model, whole=False).attribute(attribute))


def interface_hash(model: Model, interface: Interface) -> int:
    return hash64(interface_text(model, interface))


def interface_text(model: Model, interface: Interface) -> str:
    """Returns the canonical text of an interface: one line for each member and each inherited
    member, sorted."""
    writer = _Writer(model, whole=True)
    lines = []
    for member in model.all_interface_members(interface):
        if isinstance(member, Operation):
            lines.append(writer.operation(member))
        elif member.event is not None:
            lines.append(writer.operation(member.event))
        else:
            lines.append(writer.attribute(member))
    name = hashed_name(model, interface.name, interface.facts)
    return "\n".join((f"interface {name}", *sorted(lines)))


class _Writer:
    """Writes canonical texts. Where a type contains itself, the inner type is written as its name
    only."""

    def __init__(self, model: Model, whole: bool) -> None:
        self._model = model
        self._whole = whole
        self._open: list[str] = []

    def operation(self, operation: Operation) -> str:
        parameters = operation.parameters
        if not self._whole:
            parameters = parameters[: _core_length(parameters)]
        shown = ",".join(
            f"{p.direction.value} {self._slot(p.name, p.type, p.optional)}" for p in parameters
        )
        result = "void"
        if operation.result is not None:
            result = self._slot("", operation.result, operation.result_optional)
        raises = ",".join(sorted(self._named(name) for name in operation.raises))
        kind = "event" if operation.is_event else "oneway" if operation.oneway else "operation"
        name = member_name(self._model, operation)
        return f"{kind} {name}#{operation.id}({shown}):{result} raises({raises})"

    def attribute(self, attribute: Attribute) -> str:
        stream = attribute.stream.direction.value if attribute.stream else ""
        kind = "readonly" if attribute.readonly else "writable"
        name = member_name(self._model, attribute)
        value = self._slot("", attribute.type, attribute.optional)
        get_raises = ",".join(sorted(self._named(name) for name in attribute.get_raises))
        set_raises = ",".join(sorted(self._named(name) for name in attribute.set_raises))
        return (
            f"attribute {name}#{attribute.id} {kind} {stream}:{value}"
            f" get({get_raises}) set({set_raises})"
        )

    def _slot(self, name: str, used: Type, optional: bool) -> str:
        return f"{name}:{'?' if optional else ''}{self._type(used)}"

    def _type(self, used: Type) -> str:
        match used:
            case PrimitiveType(kind):
                return kind.value
            case StringType(bound):
                return f"string<{bound}>"
            case SequenceType(element, bound):
                return f"sequence<{self._type(element)},{bound}>"
            case MapType(key, value, bound):
                return f"map<{self._type(key)},{self._type(value)},{bound}>"
            case ArrayType(element, dimensions):
                return self._type(element) + "".join(f"[{d}]" for d in dimensions)
            case NamedType(name):
                return self._named(name)

    def _named(self, name: str) -> str:
        declaration = self._model.find(name)
        if isinstance(declaration, Typedef):
            return self._type(declaration.type)
        shown = hashed_name(self._model, declaration.name, declaration.facts)
        if isinstance(declaration, Interface):
            return f"object {shown}"
        if name in self._open:
            return shown
        self._open.append(name)
        try:
            return f"{shown}{{{self._contents(declaration)}}}"
        finally:
            self._open.pop()

    def _contents(self, declaration: object) -> str:
        match declaration:
            case Struct() as struct:
                members = self._model.all_members(struct)
                if struct.is_appendable and not self._whole:
                    members = members[: _core_length(members)]
                slots = ",".join(self._slot(_old_name(m), m.type, m.optional) for m in members)
                return f"{struct.extensibility.value} {slots}"
            case EnumDeclaration() as enum:
                if enum.default_literal is not None and not self._whole:
                    return f"default {enum.default_literal}"
                return ",".join(f"{e.name}={e.number}" for e in enum.enumerators)
            case Bitmask() as mask:
                return f"{mask.bit_bound} " + ",".join(f"{f.name}={f.position}" for f in mask.flags)
            case Bitset() as bits:
                fields = self._model.all_fields(bits)
                return ",".join(
                    f"{f.name}={f.position}+{f.width}{'signed' if f.is_signed else ''}"
                    for f in fields
                )
            case Union() as union:
                cases = []
                for case in union.cases:
                    labels = ",".join(_label(v) for v in case.labels)
                    default = "default" if case.is_default else ""
                    slot = self._slot(case.member.name, case.member.type, False)
                    cases.append(f"{labels}|{default}|{slot}")
                head = f"{union.extensibility.value} {self._type(union.discriminator)}"
                return head + ";" + ";".join(cases)
            case _:
                raise AssertionError(declaration)


def _old_name(member: Member) -> str:
    return member.facts.hash_as or member.name


def _core_length(slots: tuple[Member, ...] | tuple[Parameter, ...]) -> int:
    """Returns the number of members or parameters that remain after all defaulted and optional
    members or parameters at the end are left out."""
    length = len(slots)
    while length and (slots[length - 1].optional or slots[length - 1].default is not None):
        length -= 1
    return length


def _label(value: Value) -> str:
    return str(value.number) if isinstance(value, EnumValue) else repr(value)
