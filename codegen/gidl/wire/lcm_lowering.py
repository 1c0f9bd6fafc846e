"""Computes the .lcm struct of every type, and its fingerprint exactly as lcm-gen computes it.

LCM has primitives, strings, structs, and arrays of these. A dimension of an array is a constant, or
a field that holds the count. Any other type inside a sequence, optional, union or array is wrapped
in a helper struct (for example "Scan_rows_item" or "Scan_names_entry"); wrapping adds no byte to
the encoding. Count fields are named "<x>_n", and block sizes "<x>_size". Underscores are added to
the names of such fields and of helper structs until the names are unique.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

from gidl.model import (
    Bitmask,
    Bitset,
    EnumDeclaration,
    Model,
    Primitive,
    Struct,
    Type,
    Union,
)
from gidl.names.languages import CPP_WORDS
from gidl.syntax.keywords import CPP, PYTHON, words
from gidl.wire.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    MapNode,
    Node,
    ObjectNode,
    OptionalNode,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
    UnionNode,
)

LCM_PRIMITIVES = frozenset(
    ("int8_t", "int16_t", "int32_t", "int64_t", "byte", "float", "double", "string", "boolean")
)
# Names that LCM does not allow, or that lcm-gen cannot use in C++ or Python. gidl appends an
# underscore to such a name.
LCM_WORDS = LCM_PRIMITIVES | CPP | PYTHON | {"package", "encode", "decode"}
# The same for constants. More names are possible here than for members, because no fingerprint
# depends on the name of a constant: macros, and what lcm-gen declares or uses in every class.
LCM_CONSTANT_WORDS = (
    LCM_WORDS | CPP_WORDS | words("getEncodedSize getHash getTypeName get_hash staticmethod")
)

OBJECT_REF = "gecos.ObjectRef"
OBJECT_REF_DECLARED = "gecos::ObjectRef"  # declared in idl/gecos/object_ref.gidl

_SCALARS = {
    Primitive.BOOLEAN: "boolean", Primitive.OCTET: "byte", Primitive.CHAR: "int8_t",
    Primitive.INT8: "int8_t", Primitive.UINT8: "int8_t", Primitive.INT16: "int16_t",
    Primitive.UINT16: "int16_t", Primitive.INT32: "int32_t", Primitive.UINT32: "int32_t",
    Primitive.INT64: "int64_t", Primitive.UINT64: "int64_t", Primitive.FLOAT: "float",
    Primitive.DOUBLE: "double",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class LcmDimension:
    size: str  # constant length, or the name of the count field
    variable: bool


@dataclass(frozen=True, slots=True)
class LcmMember:
    name: str
    type: str  # an LCM primitive, or the full name of a struct
    dimensions: tuple[LcmDimension, ...] = ()
    # Name of the member in the .gidl file; None for count fields and for members of helper structs.
    source: str | None = None


@dataclass(frozen=True, slots=True)
class LcmConstant:
    name: str
    type: str  # "int32_t" or "int64_t"
    value: int  # signed value that fits the type


@dataclass(frozen=True, slots=True)
class LcmStruct:
    name: str  # full name, such as "robcl.Frame"
    members: tuple[LcmMember, ...]
    constants: tuple[LcmConstant, ...] = ()
    source: str | None = None  # scoped name of the .gidl declaration; None for a helper struct

    @property
    def package(self) -> str:
        return self.name.rpartition(".")[0]

    @property
    def simple_name(self) -> str:
        return self.name.rpartition(".")[2]


OBJECT_REF_STRUCT = LcmStruct(
    OBJECT_REF,
    (
        LcmMember("name", "string"),
        LcmMember("interface_hash", "int64_t"),
        LcmMember("boot", "int64_t"),
        LcmMember("where", "string"),
    ),
)


class Lowering:
    """Lowers every type of a model once, in declaration order, so that every run gives the same
    names."""

    def __init__(self, model: Model, node_of: Callable[[Model, Type, bool], Node]) -> None:
        self._model = model
        self._node_of = node_of
        self._full_names: dict[str, str] = {}
        self._taken: set[str] = {OBJECT_REF}
        self._structs: dict[str, LcmStruct] = {OBJECT_REF: OBJECT_REF_STRUCT}
        self._by_file: dict[str, list[LcmStruct]] = {f.path: [] for f in model.files}
        self._name_all()
        self._lower_all()

    def struct(self, scoped_name: str) -> LcmStruct:
        """Returns the LCM type of a struct, exception, union, enum, bitmask or bitset."""
        return self._structs[self._full_names[scoped_name]]

    def by_full_name(self, full_name: str) -> LcmStruct:
        return self._structs[full_name]

    def by_file(self) -> Mapping[str, tuple[LcmStruct, ...]]:
        return {path: tuple(structs) for path, structs in self._by_file.items()}

    def _name_all(self) -> None:
        for declaration in self._model.declarations():
            if isinstance(declaration, Struct | Union | EnumDeclaration | Bitmask | Bitset):
                wanted = self._dotted(declaration.name)
                ours = declaration.name == OBJECT_REF_DECLARED
                self._full_names[declaration.name] = wanted if ours else self._free(wanted)

    def _dotted(self, scoped_name: str) -> str:
        """Returns the LCM name of a type, for example "lab.Arm_Mode" for "lab::Arm::Mode". The
        modules of the type become its package. The name of an enclosing declaration becomes a
        prefix."""
        parts = scoped_name.split("::")
        split = len(parts) - 1
        while split > 0:
            around = "::".join(parts[:split])
            if not self._model.has(around):
                break
            split -= 1
        return ".".join((*parts[:split], "_".join(parts[split:])))

    def _free(self, wanted: str) -> str:
        while wanted in self._taken or wanted in LCM_WORDS:
            wanted += "_"
        self._taken.add(wanted)
        return wanted

    def _lower_all(self) -> None:
        for file in self._model.files:
            for declaration in file.declarations:
                if declaration.name not in self._full_names:
                    continue
                full = self._full_names[declaration.name]
                owner = _Owner(self, full, file.path)
                constants: tuple[LcmConstant, ...] = ()
                if isinstance(declaration, Struct):
                    for m in self._model.all_members(declaration):
                        node = self._node_of(self._model, m.type, m.optional)
                        owner.reserve(m.name)
                        owner.add(m.name, node)
                elif isinstance(declaration, Union):
                    self._lower_union(owner, declaration)
                elif isinstance(declaration, EnumDeclaration):
                    constants = tuple(
                        LcmConstant(owner.free_constant(e.name), "int32_t", e.number)
                        for e in declaration.enumerators
                    )
                elif isinstance(declaration, Bitmask):
                    constants = _mask_constants(declaration, owner)
                members = owner.finish()
                self.keep(LcmStruct(full, members, constants, declaration.name), file.path)

    def keep(self, struct: LcmStruct, path: str) -> None:
        self._structs[struct.name] = struct
        self._by_file[path].append(struct)

    def _lower_union(self, owner: _Owner, union: Union) -> None:
        tag = self._node_of(self._model, union.discriminator, False)
        wide = isinstance(tag, EnumNode) and tag.wire is Primitive.INT64
        if isinstance(tag, ScalarNode):
            wide = tag.primitive.size == 8 or tag.primitive is Primitive.UINT32
        for case in union.cases:
            owner.reserve(case.member.name)
        owner.add_raw(owner.free("tag"), "int64_t" if wide else "int32_t")
        for case in union.cases:
            node = self._node_of(self._model, case.member.type, False)
            owner.add(case.member.name, OptionalNode(node))

    def simple_type(self, node: Node) -> str | None:
        """Returns the LCM type of a node that is lowered to a single field without dimensions; None
        for other nodes."""
        match node:
            case ScalarNode(primitive):
                return _SCALARS[primitive]
            case EnumNode(wire=wire):
                return _SCALARS[wire]
            case StringNode():
                return "string"
            case StructNode(name) | UnionNode(name, False):
                return self._full_names[name]
            case ObjectNode():
                return OBJECT_REF
            case _:
                return None


class _Owner:
    """The struct that is being lowered: its members so far, and the names in use."""

    def __init__(self, lowering: Lowering, full_name: str, path: str) -> None:
        self._lowering = lowering
        self._full_name = full_name
        self._path = path
        self._members: list[LcmMember] = []
        self._names: dict[str, str] = {}  # name in .gidl -> name in .lcm
        self._taken: set[str] = set()
        self._pending: list[tuple[str, Node]] = []

    def reserve(self, source: str) -> None:
        """Reserves the name of a member of the .gidl type, so that no count field can get this
        name."""
        if source not in self._names:
            self._names[source] = self.free(source)

    def free(self, wanted: str, words: Set[str] = LCM_WORDS) -> str:
        while wanted in self._taken or wanted in words:
            wanted += "_"
        self._taken.add(wanted)
        return wanted

    def free_constant(self, wanted: str) -> str:
        """Returns the name of a constant, which must differ from the name of its class, too."""
        simple_name = self._full_name.rpartition(".")[2]
        return self.free(wanted, LCM_CONSTANT_WORDS | {simple_name})

    def add(self, source: str, node: Node) -> None:
        self.reserve(source)
        self._pending.append((source, node))

    def add_raw(self, name: str, lcm_type: str) -> None:
        self._members.append(LcmMember(name, lcm_type))

    def finish(self) -> tuple[LcmMember, ...]:
        for source, node in self._pending:
            self._lower(source, node)
        return tuple(self._members)

    def _lower(self, source: str, node: Node) -> None:
        name = self._names[source]
        simple = self._lowering.simple_type(node)
        if simple is not None:
            self._members.append(LcmMember(name, simple, (), source))
            return
        match node:
            case AppendableNode() | UnionNode():
                self._counted(source, name, "byte", "int32_t", "size")
            case ArrayNode(element, dimensions):
                sizes = tuple(LcmDimension(str(d), False) for d in dimensions)
                self._members.append(LcmMember(name, self._element(source, element), sizes, source))
            case SequenceNode(element=element):
                self._counted(source, name, self._element(source, element), "int32_t", "n")
            case OptionalNode(element=element):
                self._counted(source, name, self._element(source, element), "int8_t", "n")
            case MapNode(key, value):
                entry = self._helper(f"{source}_entry", (("key", key), ("value", value)))
                self._counted(source, name, entry, "int32_t", "n")
            case _:
                raise AssertionError(node)

    def _counted(self, source: str, name: str, element: str, count: str, suffix: str) -> None:
        count_name = self.free(f"{name}_{suffix}")
        self._members.append(LcmMember(count_name, count))
        sizes = (LcmDimension(count_name, True),)
        self._members.append(LcmMember(name, element, sizes, source))

    def _element(self, source: str, node: Node) -> str:
        simple = self._lowering.simple_type(node)
        return simple if simple is not None else self._helper(f"{source}_item", (("value", node),))

    def _helper(self, suffix: str, parts: tuple[tuple[str, Node], ...]) -> str:
        full = self._lowering._free(f"{self._full_name}_{suffix}")
        owner = _Owner(self._lowering, full, self._path)
        for name, node in parts:
            owner.add(name, node)
        self._lowering.keep(LcmStruct(full, owner.finish()), self._path)
        return full


def _mask_constants(mask: Bitmask, owner: _Owner) -> tuple[LcmConstant, ...]:
    bits = 64 if mask.bit_bound > 32 else 32
    constants = []
    for flag in mask.flags:
        value = 1 << flag.position
        signed = value - (1 << bits) if value >> (bits - 1) else value
        constants.append(LcmConstant(owner.free_constant(flag.name), f"int{bits}_t", signed))
    return tuple(constants)


# ---------------------------------------------------------------------------------------------
# Fingerprint

_MASK = (1 << 64) - 1


def fingerprint(lowering: Lowering, scoped_name: str) -> int:
    """Returns the fingerprint of a type's LCM struct, as a signed 64-bit number."""
    value = _fingerprint(lowering, lowering.struct(scoped_name), ())
    return _signed(value)


def _fingerprint(lowering: Lowering, struct: LcmStruct, parents: tuple[str, ...]) -> int:
    if struct.name in parents:
        return 0
    total = base_hash(struct) & _MASK
    for member in struct.members:
        if member.type not in LCM_PRIMITIVES:
            nested = lowering.by_full_name(member.type)
            total += _fingerprint(lowering, nested, (*parents, struct.name))
    total &= _MASK
    return ((total << 1) | (total >> 63)) & _MASK


def base_hash(struct: LcmStruct) -> int:
    """Returns the hash that lcm-gen computes from a struct's own members, without the members of
    nested structs. The hash is a signed 64-bit number."""
    value = 0x12345678
    for member in struct.members:
        value = _update_string(value, member.name)
        if member.type in LCM_PRIMITIVES:
            value = _update_string(value, member.type)
        value = _update(value, len(member.dimensions))
        for dimension in member.dimensions:
            value = _update(value, 1 if dimension.variable else 0)
            value = _update_string(value, dimension.size)
    return value


def _update_string(value: int, text: str) -> int:
    encoded = text.encode("utf-8")
    value = _update(value, len(encoded))
    for byte in encoded:
        value = _update(value, byte)
    return value


def _update(value: int, byte: int) -> int:
    byte &= 0xFF
    signed_char = byte - 256 if byte >= 128 else byte
    return _signed(((value << 8) ^ (value >> 55)) + signed_char)


def _signed(value: int) -> int:
    value &= _MASK
    return value - (1 << 64) if value >> 63 else value
