"""Values of interface types as JSON, and what they become: bytes, Python objects, C++ source.

    boolean, numbers, strings, char   as JSON has them
    enum                              the enumerator's name
    bitmask                           the list of its flags
    struct, exception, bitset         {"member": value}; what is left out has its default
    sequence, array                   a list; of octets the list of numbers
    @optional                         null, or the value
    union                             {"tag": value, "arm": name, "value": value}, or the tag only
    map                               [[key, value], ...] in ascending order

`encoded` is a third implementation of the encoding, by nothing but `struct` and the wire layout.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from gidl.diagnostics.findings import Findings
from gidl.files.loader import Loader
from gidl.model import (
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    EnumValue,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
)
from gidl.resolve.files import resolve
from gidl.targets.cpp.lowering import Lowering as CppLowering
from gidl.targets.cpp.names import member_name
from gidl.targets.cpp.type_text import PRIMITIVES
from gidl.targets.python import names as python_names
from gidl.targets.python.homes import Homes
from gidl.wire import wire_layout
from gidl.wire.events import events_as_streams

TREE = Path(__file__).resolve().parents[2]
VECTORS = TREE / "tests" / "vectors" / "types.json"

CODES = {
    Primitive.BOOLEAN: "b", Primitive.OCTET: "B", Primitive.INT8: "b", Primitive.UINT8: "B",
    Primitive.INT16: "h", Primitive.UINT16: "H", Primitive.INT32: "i", Primitive.UINT32: "I",
    Primitive.INT64: "q", Primitive.UINT64: "Q", Primitive.FLOAT: "f", Primitive.DOUBLE: "d",
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    type: str
    name: str
    value: Any
    bytes: bytes

    @property
    def id(self) -> str:
        return f"{self.type}: {self.name}"


def cases() -> list[Case]:
    listed = json.loads(VECTORS.read_text(encoding="utf-8"))
    return [Case(c["type"], c["name"], c["value"], bytes.fromhex(c["bytes"])) for c in listed]


def load() -> Model:
    """All interfaces of the tree, and the one with everything; events are streams."""
    idl, own = TREE / "idl", TREE / "tests" / "idl"
    findings = Findings()
    loader = Loader(findings, (idl, own))
    vocabulary = loader.load_vocabulary()
    loader.load_all(str(path) for path in sorted([*idl.rglob("*.gidl"), *own.glob("*.gidl")]))
    model = resolve(loader.files.values(), vocabulary, findings)
    assert not findings.has_errors, findings.found
    return events_as_streams(model)


# ---------------------------------------------------------------------------------------------
# Bytes


def encoded(model: Model, name: str, value: Any) -> bytes:
    """The fields of a struct, exception or union."""
    declaration = model.find(name)
    if isinstance(declaration, Union):
        return _union(model, declaration, value)
    assert isinstance(declaration, Struct)
    out = b""
    for member in model.all_members(declaration):
        given = value.get(member.name, _default(model, member))
        if member.optional:
            out += b"\0" if given is None else b"\1"
        if not (member.optional and given is None):
            out += _encoded(model, member.type, given)
    return out


def _encoded(model: Model, used: Type, value: Any) -> bytes:
    target = model.target(used)
    match target:
        case PrimitiveType(Primitive.CHAR):
            return str(value).encode("latin-1")
        case PrimitiveType(kind):
            return struct.pack(">" + CODES[kind], value)
        case StringType():
            raw = str(value).encode()
            return struct.pack(">i", len(raw) + 1) + raw + b"\0"
        case SequenceType(element):
            body = b"".join(_encoded(model, element, item) for item in value)
            return struct.pack(">i", len(value)) + body
        case ArrayType(element, dimensions):
            return _array(model, element, dimensions, value)
        case MapType(key, item):
            body = b"".join(_encoded(model, key, k) + _encoded(model, item, v) for k, v in value)
            return struct.pack(">i", len(value)) + body
        case NamedType(name):
            return _named(model, name, value)


def _array(model: Model, element: Type, dimensions: tuple[int, ...], value: Any) -> bytes:
    if not dimensions:
        return _encoded(model, element, value)
    assert len(value) == dimensions[0]
    return b"".join(_array(model, element, dimensions[1:], item) for item in value)


def value_type(model: Model, name: str) -> str:
    """What a value is where the type is called `name`: of an interface, a reference."""
    return "gecos::ObjectRef" if isinstance(model.find(name), Interface) else name


def _named(model: Model, name: str, value: Any) -> bytes:
    name = value_type(model, name)
    declaration = model.find(name)
    match declaration:
        case EnumDeclaration():
            return struct.pack(">i", _number(declaration, value))
        case Bitmask(bit_bound=bits):
            number = sum(1 << f.position for f in declaration.flags if f.name in value)
            return struct.pack(">Q" if bits > 32 else ">I", number)
        case Bitset(bit_size=bits):
            number = 0
            for f in model.all_fields(declaration):
                number |= (int(value.get(f.name, 0)) & ((1 << f.width) - 1)) << f.position
            return struct.pack(">Q" if bits > 32 else ">I", number)
        case Struct() | Union():
            fields = encoded(model, name, value)
            grows = declaration.extensibility.value == "appendable"
            return struct.pack(">i", len(fields)) + fields if grows else fields
    raise AssertionError(name)


def _union(model: Model, union: Union, value: Any) -> bytes:
    tag = value["tag"]
    target = model.target(union.discriminator)
    wide = target in (PrimitiveType(Primitive.UINT64), PrimitiveType(Primitive.INT64))
    wide = wide or target == PrimitiveType(Primitive.UINT32)
    if isinstance(target, NamedType):
        declaration = model.find(target.name)
        assert isinstance(declaration, EnumDeclaration)
        tag = _number(declaration, tag)
    out = (int(tag) & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "big")
    out = out if wide else out[4:]
    for case in union.cases:
        if case.member.name == value.get("arm"):
            out += b"\1" + _encoded(model, case.member.type, value["value"])
        else:
            out += b"\0"
    return out


def _number(enum: EnumDeclaration, name: str) -> int:
    return next(e.number for e in enum.enumerators if e.name == name)


def _default(model: Model, member: Member) -> Any:
    if member.optional:
        return None
    if member.default is not None:
        given = member.default
        return given.literal if isinstance(given, EnumValue) else given
    return _zero(model, member.type)


def _zero(model: Model, used: Type) -> Any:
    target = model.target(used)
    match target:
        case PrimitiveType(Primitive.BOOLEAN):
            return False
        case PrimitiveType(Primitive.CHAR):
            return "\0"
        case PrimitiveType():
            return 0
        case StringType():
            return ""
        case SequenceType() | MapType():
            return []
        case ArrayType(element, dimensions):
            value = _zero(model, element)
            for size in reversed(dimensions):
                value = [value] * size
            return value
        case NamedType("robcl::Frame"):
            return {"orientation": {"w": 1.0}}
        case NamedType(name):
            declaration = model.find(name)
            match declaration:
                case EnumDeclaration():
                    return declaration.initial.name
                case Bitmask():
                    return []
                case Union():
                    tag = _zero(model, declaration.discriminator)
                    return {"tag": tag}
            return {}


# ---------------------------------------------------------------------------------------------
# Python


_HOMES: dict[int, Homes] = {}  # by model, which takes long to lay out


def python_type(model: Model, name: str) -> Any:
    """The generated class, or the one written by hand."""
    if id(model) not in _HOMES:
        _HOMES[id(model)] = Homes(model, wire_layout.build(model))
    module, called = _HOMES[id(model)].value(name)
    return getattr(import_module(module), called)


def python_value(model: Model, used: Type, value: Any) -> Any:
    target = model.target(used)
    match target:
        case SequenceType(PrimitiveType(Primitive.OCTET)):
            return bytes(value)
        case SequenceType(element):
            return _python_list(model, element, value)
        case ArrayType(PrimitiveType(Primitive.OCTET), (_,)):
            return bytes(value)
        case ArrayType(element, dimensions):
            inner: Type = element
            for size in reversed(dimensions[1:]):
                inner = ArrayType(inner, (size,))
            return _python_list(model, inner, value)
        case MapType(key, item):
            return {python_value(model, key, k): python_value(model, item, v) for k, v in value}
        case NamedType(name):
            return python_struct(model, name, value)
        case _:
            return value


def _python_list(model: Model, element: Type, value: Any) -> Any:
    import numpy as np

    innermost = element if isinstance(element, ArrayType) else model.target(element)
    while isinstance(innermost, ArrayType):
        innermost = model.target(innermost.element)
    plain = isinstance(model.target(element), PrimitiveType) or isinstance(element, ArrayType)
    if plain and isinstance(innermost, PrimitiveType) and innermost.kind is not Primitive.CHAR:
        boolean = innermost.kind is Primitive.BOOLEAN
        return np.array(value, dtype="?" if boolean else CODES[innermost.kind])
    return [python_value(model, element, item) for item in value]


def python_struct(model: Model, name: str, value: Any) -> Any:
    name = value_type(model, name)
    declaration = model.find(name)
    kind = python_type(model, name)
    match declaration:
        case EnumDeclaration():
            return kind[value]
        case Bitmask():
            made = kind(0)
            for flag in value:
                made |= kind[flag]
            return made
        case Bitset():
            return kind(**value)
        case Union():
            tag = python_value(model, declaration.discriminator, value["tag"])
            held = None
            for case in declaration.cases:
                if case.member.name == value.get("arm"):
                    held = python_value(model, case.member.type, value["value"])
            return kind(tag, held)
    assert isinstance(declaration, Struct)
    if name == "robcl::Frame":
        return kind.from_quaternion(*_seven(value))
    members = {m.name: m for m in model.all_members(declaration)}
    arguments = {}
    for member_key, given in value.items():
        member = members[member_key]
        made = None if given is None else python_value(model, member.type, given)
        arguments[python_names.member_name(member.name)] = made
    return kind(**arguments)


def _seven(value: Any) -> tuple[float, ...]:
    position, turn = value.get("position", {}), value.get("orientation", {"w": 1.0})
    return (*(position.get(k, 0.0) for k in "xyz"), *(turn.get(k, 0.0) for k in "wxyz"))


# ---------------------------------------------------------------------------------------------
# C++


class CppWriter:
    """Writes values as C++ expressions."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._lowering = CppLowering(model, wire_layout.build(model))
        self._made = 0  # values so far: each gets a variable of its own

    def expression(self, used: Type, value: Any, optional: bool = False) -> str:
        if optional and value is None:
            return "std::nullopt"
        target = self._model.target(used)
        name = self._lowering.type(used)
        match target:
            case PrimitiveType(Primitive.BOOLEAN):
                return "true" if value else "false"
            case PrimitiveType(Primitive.CHAR):
                return f"static_cast<char>({ord(value)})"
            case PrimitiveType(kind) if kind.is_floating:
                return f"static_cast<{PRIMITIVES[kind]}>({float(value)!r})"
            case PrimitiveType(kind):
                return f"static_cast<{PRIMITIVES[kind]}>({_cpp_integer(value)})"
            case StringType():
                return f"std::string({_cpp_text(value)})"
            case SequenceType(element):
                items = ", ".join(self.expression(element, item) for item in value)
                return f"{name}{{{items}}}"
            case ArrayType(element, dimensions):
                return self._array(element, dimensions, value)
            case MapType(key, item):
                pairs = (
                    f"{{{self.expression(key, k)}, {self.expression(item, v)}}}" for k, v in value
                )
                return f"{name}{{{', '.join(pairs)}}}"
            case NamedType(scoped):
                return self.named(scoped, value)

    def _array(self, element: Type, dimensions: tuple[int, ...], value: Any) -> str:
        if not dimensions:
            return self.expression(element, value)
        name = self._lowering.type(ArrayType(element, dimensions))
        items = ", ".join(self._array(element, dimensions[1:], item) for item in value)
        return f"{name}{{{items}}}"

    def named(self, scoped: str, value: Any) -> str:
        scoped = value_type(self._model, scoped)
        declaration = self._model.find(scoped)
        name = self._lowering.named(scoped)
        self._made += 1
        v = f"v{self._made}"
        match declaration:
            case EnumDeclaration():
                return f"{name}::{value}"
            case Bitmask():
                flags = " | ".join(f"{name}::{flag}" for flag in value)
                return f"({flags})" if flags else f"{name}{{}}"
            case Bitset():
                bits = " ".join(f"{v}.{key} = {_cpp_integer(int(n))};" for key, n in value.items())
                return f"[] {{ {name} {v}; {bits} return {v}; }}()"
            case Union():
                tag = self.expression(declaration.discriminator, value["tag"])
                held = ""
                for index, case in enumerate(declaration.cases, start=1):
                    if case.member.name == value.get("arm"):
                        made = self.expression(case.member.type, value["value"])
                        held = f"{v}.value.emplace<{index}>({made});"
                return f"[] {{ {name} {v}; {v}.tag = {tag}; {held} return {v}; }}()"
        assert isinstance(declaration, Struct)
        if scoped == "robcl::Frame":
            return f"{name}::from_quaternion({', '.join(repr(float(n)) for n in _seven(value))})"
        members = {m.name: m for m in self._model.all_members(declaration)}
        sets = []
        for key, given in value.items():
            member = members[key]
            made = self.expression(member.type, given, member.optional)
            sets.append(f"{v}.{member_name(key)} = {made};")
        return f"[] {{ {name} {v}; {' '.join(sets)} return {v}; }}()"


def _cpp_integer(value: int) -> str:
    if value == -(1 << 63):
        return "std::numeric_limits<std::int64_t>::min()"
    return f"{value}U" if value >= 1 << 31 else str(value)


def _cpp_text(text: str) -> str:
    return '"' + "".join(f"\\{byte:03o}" for byte in text.encode()) + '"'
