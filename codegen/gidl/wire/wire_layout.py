"""The wire encoding of a model: one node for each value, and one layout for each type and call.

The encoding is that of LCM (big-endian, fields in order). Types that LCM lacks are lowered:

    ScalarNode: 1 to 8 bytes. Unsigned integers and char are bit-cast to the signed type of their
        width. `limits` is the range of the value, which may be an element, key or union arm.
    EnumNode: an enum, bitmask or bitset, as int32 (as int64 if it has more than 32 bits).
    StringNode: an int32 length that includes the NUL, then the text in UTF-8, then a NUL.
    StructNode: the fields of a final struct, without fingerprint.
    AppendableNode: an int32 size, then a block of that many bytes with the fields.
    UnionNode: the tag, then for each arm an int8 with 0 or 1; the arm follows if it is 1.
    ArrayNode: the elements.
    SequenceNode: an int32 count, then the elements.
    OptionalNode: an int8 with 0 or 1; the value follows if it is 1.
    MapNode: an int32 count, then key and value of each entry, sorted by key.
    ObjectNode: the fields of gecos.ObjectRef; an empty name is a nil reference.

The body of a request holds the `in` and `inout` parameters in order. The body of a reply holds the
result, then the `inout` and `out` parameters. A later version of an interface may add values at the
end of a body. A reader ignores added bytes that it does not know. If an optional or defaulted value
is missing at the end, the reader takes no value or the default. A stream sample is encoded like the
reply body of its attribute's getter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from gidl.model import (
    ArrayType,
    Attribute,
    Bitmask,
    Bitset,
    EnumDeclaration,
    ExceptionStruct,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Operation,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    within,
)
from gidl.names.languages import CPP_TYPES, PYTHON_TYPES
from gidl.names.type_names import TypeNames, name_types
from gidl.wire import function_codes, hashes
from gidl.wire.lcm_lowering import LcmStruct, Lowering, fingerprint
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

_LARGEST_SAMPLE = 2**30  # bytes; the memory of a stream is never larger

# The size of the smallest object reference in bytes: two empty strings (length and NUL each) and
# two int64.
_OBJECT_MIN_SIZE = 2 * 5 + 2 * 8


@dataclass(frozen=True, slots=True)
class FieldLayout:
    """A member, parameter or result, and its encoding on the wire."""

    name: str
    node: Node
    min_size: int
    fixed_size: int | None  # bytes of each value; None: the size varies


@dataclass(frozen=True, slots=True)
class StructLayout:
    """The layout of a struct or exception. Sizes are in bytes, and count the fields without
    fingerprint or size prefix."""

    name: str
    fields: tuple[FieldLayout, ...]  # all fields, inherited ones first
    appendable: bool
    min_size: int
    fixed_size: int | None
    lcm: LcmStruct
    fingerprint: int  # signed 64 bits, as lcm-gen computes fingerprints


@dataclass(frozen=True, slots=True)
class UnionLayout:
    name: str
    tag: ScalarNode | EnumNode  # node of the declared discriminator
    wire_tag: Primitive  # INT32, or INT64 for 64-bit and uint32 discriminators
    arms: tuple[FieldLayout, ...]  # in the order of the cases; sizes do not include the int8
    appendable: bool
    min_size: int
    lcm: LcmStruct
    fingerprint: int


class CallKind(Enum):
    OPERATION = "operation"
    GETTER = "getter"
    SETTER = "setter"


@dataclass(frozen=True, slots=True)
class CallLayout:
    """The encoding of one call. A call belongs to an operation, a getter or a setter."""

    kind: CallKind
    name: str  # scoped name; that of a setter has "=" at its end
    code: int
    request: tuple[FieldLayout, ...]
    reply: tuple[FieldLayout, ...]
    exceptions: tuple[tuple[str, int], ...]  # scoped name and code of each declared exception
    hash: int  # operation hash, unsigned 64 bits; see hashes.py


@dataclass(frozen=True, slots=True)
class StreamLayout:
    """The encoding of the samples of a stream. `code` is the function code of the attribute's
    getter. An attribute without a getter has the code that its getter would have."""

    name: str
    code: int
    sample: FieldLayout
    largest: int | None  # bytes of the largest sample of this declaration; None: not limited
    fingerprint: int | None  # fingerprint of a struct sample, sent first on an @open_stream
    hash: int


@dataclass(frozen=True, slots=True)
class InterfaceLayout:
    name: str
    hash: int  # interface hash, unsigned 64 bits; see hashes.py
    calls: tuple[CallLayout, ...]  # without inherited calls: see `Layout.all_calls`
    streams: tuple[StreamLayout, ...]


@dataclass(frozen=True, slots=True)
class Layout:
    structs: Mapping[str, StructLayout]
    unions: Mapping[str, UnionLayout]
    interfaces: Mapping[str, InterfaceLayout]
    lcm_structs: Mapping[str, tuple[LcmStruct, ...]]  # by file, helper structs first
    cpp_names: TypeNames
    python_names: TypeNames

    def all_calls(self, model: Model, interface: Interface) -> tuple[CallLayout, ...]:
        return tuple(c for i in model.with_bases(interface) for c in self.interfaces[i.name].calls)

    def call(self, scoped_name: str) -> CallLayout:
        """Returns the call with the scoped name of its operation or attribute. The name of a setter
        has "=" at its end."""
        owner = scoped_name.rpartition("::")[0]
        return next(c for c in self.interfaces[owner].calls if c.name == scoped_name)

    def stream(self, scoped_name: str) -> StreamLayout:
        owner = scoped_name.rpartition("::")[0]
        return next(s for s in self.interfaces[owner].streams if s.name == scoped_name)


def build(model: Model) -> Layout:
    """Lays out every type and interface of `model`. @pre the rules found no error in `model`, and
    it has no events: see `gidl.wire.events`."""
    return _Builder(model).build()


def node_of(
    model: Model,
    used: Type,
    optional: bool = False,
    limits: Range | None = None,
    unit: str | None = None,
) -> Node:
    """Returns the node of a value of type `used`, with typedefs resolved. `limits` and `unit` are
    the range and the unit that are declared for the value. Range and unit apply to the number, or
    to the elements of an array or sequence."""
    node = _bare_node(model, used, limits, unit)
    return OptionalNode(node) if optional else node


def _bare_node(
    model: Model, used: Type, limits: Range | None = None, unit: str | None = None
) -> Node:
    match used:
        case PrimitiveType(kind):
            binding = _binding(kind, limits)
            return ScalarNode(kind, binding, unit if binding is not None else None)
        case StringType(bound):
            return StringNode(bound)
        case SequenceType(element, bound, inner_unit):
            return SequenceNode(_bare_node(model, element, limits, unit or inner_unit), bound)
        case MapType(key, value, bound):
            return MapNode(_bare_node(model, key), _bare_node(model, value), bound)
        case ArrayType(element, dimensions):
            return ArrayNode(_bare_node(model, element, limits, unit), dimensions)
        case NamedType(name):
            return _named_node(model, name, limits, unit)


def _binding(kind: Primitive, limits: Range | None) -> Range | None:
    """Returns `limits`, or None if no value of the type can violate them."""
    number = ScalarNode(kind, limits if kind.is_number else None)
    return limits if number.bounds is not None else None


def _named_node(model: Model, name: str, limits: Range | None, unit: str | None) -> Node:
    match model.find(name):
        case Typedef(type=target, range=own, unit=own_unit):
            return _bare_node(model, target, within(limits, own), unit or own_unit)
        case Struct() as struct:
            return AppendableNode(name) if struct.is_appendable else StructNode(name)
        case Union() as union:
            return UnionNode(name, union.extensibility.value == "appendable")
        case EnumDeclaration(bit_bound=bits) | Bitmask(bit_bound=bits) | Bitset(bit_size=bits):
            return EnumNode(name, Primitive.INT64 if bits > 32 else Primitive.INT32)
        case Interface():
            return ObjectNode(name)
        case other:
            raise AssertionError(f"{other.name} is not a type")


class _Builder:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._lowering = Lowering(model, node_of)
        self._fields: dict[str, tuple[FieldLayout, ...]] = {}

    def build(self) -> Layout:
        structs: dict[str, StructLayout] = {}
        unions: dict[str, UnionLayout] = {}
        interfaces: dict[str, InterfaceLayout] = {}
        for declaration in self._model.declarations():
            if isinstance(declaration, Struct):
                structs[declaration.name] = self._struct(declaration)
            elif isinstance(declaration, Union):
                unions[declaration.name] = self._union(declaration)
            elif isinstance(declaration, Interface):
                interfaces[declaration.name] = self._interface(declaration)
        return Layout(
            structs,
            unions,
            interfaces,
            self._lowering.by_file(),
            name_types(self._model, CPP_TYPES),
            name_types(self._model, PYTHON_TYPES),
        )

    def _struct(self, struct: Struct) -> StructLayout:
        fields = self._struct_fields(struct)
        return StructLayout(
            struct.name,
            fields,
            struct.is_appendable,
            sum(f.min_size for f in fields),
            _sum_fixed(fields),
            self._lowering.struct(struct.name),
            fingerprint(self._lowering, struct.name),
        )

    def _struct_fields(self, struct: Struct) -> tuple[FieldLayout, ...]:
        if struct.name not in self._fields:
            members = self._model.all_members(struct)
            self._fields[struct.name] = tuple(
                self._field(m.name, m.type, m.optional, m.range, m.unit) for m in members
            )
        return self._fields[struct.name]

    def _union(self, union: Union) -> UnionLayout:
        tag = node_of(self._model, union.discriminator)
        assert isinstance(tag, ScalarNode | EnumNode)
        arms = tuple(
            self._field(m.name, m.type, False, m.range, m.unit)
            for m in (case.member for case in union.cases)
        )
        wire_tag = wire_tag_of(tag)
        return UnionLayout(
            union.name,
            tag,
            wire_tag,
            arms,
            union.extensibility.value == "appendable",
            _union_min_size(self._model, union),
            self._lowering.struct(union.name),
            fingerprint(self._lowering, union.name),
        )

    def _field(
        self, name: str, used: Type, optional: bool, limits: Range | None, unit: str | None
    ) -> FieldLayout:
        node = node_of(self._model, used, optional, limits, unit)
        return FieldLayout(
            name, node, min_size_of(self._model, node), fixed_size_of(self._model, node)
        )

    def _interface(self, interface: Interface) -> InterfaceLayout:
        calls: list[CallLayout] = []
        streams: list[StreamLayout] = []
        for member in interface.members:
            if isinstance(member, Operation):
                calls.append(self._operation(member))
            else:
                calls.extend(self._attribute_calls(member))
                if member.stream is not None:
                    streams.append(self._stream(member))
        return InterfaceLayout(
            interface.name,
            hashes.interface_hash(self._model, interface),
            tuple(calls),
            tuple(streams),
        )

    def _operation(self, operation: Operation) -> CallLayout:
        assert not operation.is_event, operation.scoped_name
        request, reply = (
            [self._field(p.name, p.type, p.optional, p.range, p.unit) for p in passed]
            for passed in (operation.inputs, operation.outputs)
        )
        if operation.result is not None:
            name = "result"
            while any(f.name == name for f in reply):
                name += "_"
            result = self._field(
                name,
                operation.result,
                operation.result_optional,
                operation.result_range,
                operation.result_unit,
            )
            reply.insert(0, result)
        return CallLayout(
            CallKind.OPERATION,
            operation.scoped_name,
            function_codes.call_code(self._model, operation),
            tuple(request),
            tuple(reply),
            self._exceptions(operation.raises),
            hashes.operation_hash(self._model, operation),
        )

    def _attribute_value(self, attribute: Attribute) -> FieldLayout:
        a = attribute
        return self._field("value", a.type, a.optional, a.range, a.unit)

    def _attribute_calls(self, attribute: Attribute) -> list[CallLayout]:
        value = self._attribute_value(attribute)
        digest = hashes.attribute_hash(self._model, attribute)
        calls = []
        if attribute.has_getter:
            calls.append(
                CallLayout(
                    CallKind.GETTER,
                    attribute.scoped_name,
                    function_codes.call_code(self._model, attribute),
                    (),
                    (value,),
                    self._exceptions(attribute.get_raises),
                    digest,
                )
            )
        if attribute.has_setter:
            calls.append(
                CallLayout(
                    CallKind.SETTER,
                    attribute.scoped_name + "=",
                    function_codes.setter_code(self._model, attribute),
                    (value,),
                    (),
                    self._exceptions(attribute.set_raises),
                    digest,
                )
            )
        return calls

    def _stream(self, attribute: Attribute) -> StreamLayout:
        sample = self._attribute_value(attribute)
        node = sample.node
        struct = node.name if isinstance(node, StructNode | AppendableNode) else None
        return StreamLayout(
            attribute.scoped_name,
            function_codes.call_code(self._model, attribute),
            sample,
            self._largest(sample),
            None if struct is None else fingerprint(self._lowering, struct),
            hashes.attribute_hash(self._model, attribute),
        )

    def _largest(self, sample: FieldLayout) -> int | None:
        """Returns the size of the largest sample in bytes, or None if the size is not limited. The
        size is that of samples from a sender with this declaration. Members that a later version of
        an appendable struct adds therefore do not count."""
        size = max_size_of(self._model, sample.node)
        return size if size is not None and size <= _LARGEST_SAMPLE else None

    def _exceptions(self, names: tuple[str, ...]) -> tuple[tuple[str, int], ...]:
        found = []
        for name in names:
            exception = self._model.find(name)
            assert isinstance(exception, ExceptionStruct)
            found.append((name, function_codes.exception_code(self._model, exception)))
        return tuple(found)


def wire_tag_of(tag: ScalarNode | EnumNode) -> Primitive:
    """Returns the integer type of a union's tag: int64 if int32 cannot hold every value, else
    int32."""
    if isinstance(tag, EnumNode):
        return tag.wire
    wide = tag.primitive.size == 8 or tag.primitive is Primitive.UINT32
    return Primitive.INT64 if wide else Primitive.INT32


def min_size_of(model: Model, node: Node) -> int:
    """Returns the size of the smallest value in bytes. A decoder uses the size to refuse an element
    count for which the message has too few bytes."""
    match node:
        case ScalarNode(primitive):
            return primitive.size
        case EnumNode(wire=wire):
            return wire.size
        case StringNode():
            return 5
        case StructNode(name):
            members = model.all_members(model.struct(name))
            return sum(min_size_of(model, node_of(model, m.type, m.optional)) for m in members)
        case AppendableNode() | SequenceNode() | MapNode() | UnionNode(appendable=True):
            return 4
        case OptionalNode():
            return 1
        case UnionNode(name):
            declaration = model.find(name)
            assert isinstance(declaration, Union)
            return _union_min_size(model, declaration)
        case ArrayNode(element=element, count=count):
            return count * min_size_of(model, element)
        case ObjectNode():
            return _OBJECT_MIN_SIZE


def fixed_size_of(model: Model, node: Node) -> int | None:
    """Returns the size of a value in bytes if all values have the same size, else None."""
    match node:
        case ScalarNode() | EnumNode():
            return min_size_of(model, node)
        case StructNode(name):
            members = model.all_members(model.struct(name))
            sizes = [fixed_size_of(model, node_of(model, m.type, m.optional)) for m in members]
            return None if None in sizes else sum(size for size in sizes if size is not None)
        case ArrayNode(element=element, count=count):
            each = fixed_size_of(model, element)
            return None if each is None else count * each
        case _:
            return None


def max_size_of(model: Model, node: Node, outer: frozenset[str] = frozenset()) -> int | None:
    """Returns the size of the largest value in bytes, or None if the size is not limited. `outer`
    has the structs that contain the value. The size of a struct that contains itself is not
    limited."""

    def times(count: int | None, each: int | None) -> int | None:
        return None if count is None or each is None else count * each

    match node:
        case ScalarNode() | EnumNode():
            return min_size_of(model, node)
        case StringNode(bound):
            return None if bound is None else 5 + bound
        case StructNode(name) | AppendableNode(name):
            sizes = _largest_members(model, model.all_members(model.struct(name)), name, outer)
            prefix = 4 if isinstance(node, AppendableNode) else 0
            return None if sizes is None else prefix + sum(sizes)
        case UnionNode(name):
            union = model.find(name)
            assert isinstance(union, Union)
            sizes = _largest_members(model, (case.member for case in union.cases), name, outer)
            prefix = (4 if node.appendable else 0) + _union_min_size(model, union)
            return None if sizes is None else prefix + max(sizes)
        case OptionalNode(element):
            each = max_size_of(model, element, outer)
            return None if each is None else 1 + each
        case ArrayNode(element=element, count=count):
            return times(count, max_size_of(model, element, outer))
        case SequenceNode(element, bound):
            whole = times(bound, max_size_of(model, element, outer))
            return None if whole is None else 4 + whole
        case MapNode(key, value, bound):
            one = [max_size_of(model, each, outer) for each in (key, value)]
            pair = None if None in one else sum(each for each in one if each is not None)
            whole = times(bound, pair)
            return None if whole is None else 4 + whole
        case ObjectNode():
            return None


def _largest_members(
    model: Model, members: Iterable[Member], name: str, outer: frozenset[str]
) -> list[int] | None:
    """Returns the largest size of each of the `members` of the struct or union `name`, in bytes.
    Returns None if the size of a member is not limited."""
    if name in outer:
        return None
    inside = outer | {name}
    sizes = [max_size_of(model, node_of(model, m.type, m.optional), inside) for m in members]
    return None if None in sizes else [size for size in sizes if size is not None]


def _union_min_size(model: Model, union: Union) -> int:
    tag = node_of(model, union.discriminator)
    assert isinstance(tag, ScalarNode | EnumNode)
    return wire_tag_of(tag).size + len(union.cases)


def _sum_fixed(fields: tuple[FieldLayout, ...]) -> int | None:
    total = 0
    for field in fields:
        if field.fixed_size is None:
            return None
        total += field.fixed_size
    return total
