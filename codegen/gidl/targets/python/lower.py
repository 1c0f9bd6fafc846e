"""Types and codecs in Python: hints, defaults, how a value is written and read.

Writing is statements that append to `out`; reading is an expression over `source`. Fixed-size
numbers that follow each other, nested structs opened up, form one run: a `struct` of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from gidl.model import (
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    EnumValue,
    MapType,
    Member,
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
    Value,
)
from gidl.targets.naming import LocalNames, range_text, within
from gidl.targets.python import names
from gidl.wire_layout import Layout, min_size_of, node_of
from gidl.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    MapNode,
    Node,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
    UnionNode,
)

CODES = {
    Primitive.BOOLEAN: "?", Primitive.OCTET: "B", Primitive.CHAR: "B", Primitive.INT8: "b",
    Primitive.UINT8: "B", Primitive.INT16: "h", Primitive.UINT16: "H", Primitive.INT32: "i",
    Primitive.UINT32: "I", Primitive.INT64: "q", Primitive.UINT64: "Q", Primitive.FLOAT: "f",
    Primitive.DOUBLE: "d",
}  # fmt: skip
DTYPES = {
    "?": "bool_", "b": "int8", "B": "uint8", "h": "int16", "H": "uint16", "i": "int32",
    "I": "uint32", "q": "int64", "Q": "uint64", "f": "float32", "d": "float64",
}  # fmt: skip
SIZES = {"?": 1, "b": 1, "B": 1, "h": 2, "H": 2, "i": 4, "I": 4, "q": 8, "Q": 8, "f": 4, "d": 8}


@dataclass(frozen=True, slots=True)
class Slot:
    """A value with a place; `label` is what messages call it."""

    expression: str
    label: str
    type: Type
    optional: bool = False
    range: Range | None = None


@dataclass(slots=True)
class Leaf:
    """One number of a run."""

    code: str
    access: str
    label: str
    type: Type
    limits: Range | None


@dataclass(slots=True)
class Run:
    leaves: list[Leaf] = field(default_factory=list)

    @property
    def size(self) -> int:
        return sum(SIZES[leaf.code] for leaf in self.leaves)

    def behind(self, index: int) -> int:
        """Bytes from the start of a leaf to the end of the run."""
        return sum(SIZES[leaf.code] for leaf in self.leaves[index:])


class Lowering:
    def __init__(self, model: Model, layout: Layout) -> None:
        self.model = model
        self.layout = layout

    # -- types and values ------------------------------------------------------------------------

    def hint(self, used: Type, optional: bool = False) -> str:
        if optional:
            return f"{self.hint(used)} | None"
        match used:
            case PrimitiveType(Primitive.BOOLEAN):
                return "bool"
            case PrimitiveType(Primitive.CHAR) | StringType():
                return "str"
            case PrimitiveType(kind):
                return "float" if kind.is_floating else "int"
            case SequenceType(element) | ArrayType(element):
                node = node_of(self.model, element)
                if is_octet(node):
                    return "bytes"
                code = self.bulk_code(node)
                if code is not None:
                    return f"npt.NDArray[np.{DTYPES[code]}]"
                text = self.hint(element)
                depth = len(used.dimensions) if isinstance(used, ArrayType) else 1
                for _ in range(depth):
                    text = f"list[{text}]"
                return text
            case MapType(key, value):
                return f"dict[{self.hint(key)}, {self.hint(value)}]"
            case NamedType(name):
                declaration = self.model.find(name)
                if isinstance(declaration, Typedef):
                    return self.hint(declaration.type)
                return names.type_name(self.model, name)
        raise AssertionError(used)

    def holds_array(self, used: Type) -> bool:
        """Whether `==` needs help: arrays compare element by element."""
        return "npt.NDArray" in self.hint(used)

    def literal(self, value: Value, used: Type) -> str:
        match value:
            case EnumValue(enum, literal):
                return f"{names.type_name(self.model, enum)}.{names.enumerator(literal)}"
            case bool() | str():
                return quoted(value) if isinstance(value, str) else str(value)
            case _:
                target = self.model.target(used)
                floating = isinstance(target, PrimitiveType) and target.kind.is_floating
                return repr(float(value)) if floating else str(value)

    def initial(self, member: Member) -> tuple[str, bool]:
        """Default expression, and whether it has to be made anew for each value."""
        if member.optional:
            return "None", False
        if member.default is not None:
            return self.literal(member.default, member.type), False
        return self._zero(member.type)

    def _zero(self, used: Type) -> tuple[str, bool]:
        target = self.model.target(used)
        match target:
            case PrimitiveType(Primitive.BOOLEAN):
                return "False", False
            case PrimitiveType(Primitive.CHAR):
                return '"\\0"', False
            case PrimitiveType(kind):
                return ("0.0" if kind.is_floating else "0"), False
            case StringType():
                return '""', False
            case MapType():
                return "dict", True
            case SequenceType(element):
                node = node_of(self.model, element)
                if is_octet(node):
                    return 'b""', False
                code = self.bulk_code(node)
                return (f'lambda: wire.zeros("{code}", 0)' if code else "list"), True
            case ArrayType(element, dimensions):
                return self._zero_array(element, dimensions)
            case NamedType(name):
                declaration = self.model.find(name)
                mine = names.type_name(self.model, name)
                if isinstance(declaration, EnumDeclaration):
                    return f"{mine}.{names.enumerator(declaration.initial.name)}", False
                if isinstance(declaration, Bitmask):
                    return f"{mine}(0)", False
                return mine, True
        raise AssertionError(target)

    def _zero_array(self, element: Type, dimensions: tuple[int, ...]) -> tuple[str, bool]:
        node = node_of(self.model, element)
        if is_octet(node) and len(dimensions) == 1:
            return f"b'\\0' * {dimensions[0]}", False
        code = self.bulk_code(node)
        if code is not None:
            shape = ", ".join(str(d) for d in dimensions)
            return f'lambda: wire.zeros("{code}", {shape})', True
        inner, made = self._zero(element)
        text = f"{inner.removeprefix('lambda: ')}" if inner.startswith("lambda: ") else inner
        text = f"{text}()" if made and not inner.startswith("lambda: ") else text
        for size in reversed(dimensions):
            text = f"[{text} for _ in range({size})]"
        return f"lambda: {text}", True

    def bulk_code(self, element: Node) -> str | None:
        """Code of elements that are kept in a numpy array."""
        if isinstance(element, ScalarNode) and element.primitive is not Primitive.CHAR:
            return CODES[element.primitive]
        return None

    def limits(self, slot: Slot) -> Range | None:
        """Bounds of a number, those of its typedefs included."""
        limits, used = slot.range, slot.type
        while isinstance(used, NamedType):
            declaration = self.model.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            limits, used = within(limits, declaration.range), declaration.type
        return limits

    # -- runs --------------------------------------------------------------------------------------

    def leaves(self, slot: Slot) -> list[Leaf] | None:
        """The numbers a value consists of, when it is nothing but fixed-size numbers."""
        if slot.optional:
            return None
        node = node_of(self.model, slot.type)
        match node:
            case ScalarNode(Primitive.CHAR):
                return None
            case ScalarNode(primitive):
                limits = self.limits(slot)
                return [Leaf(CODES[primitive], slot.expression, slot.label, slot.type, limits)]
            case EnumNode(name, wire):
                if isinstance(self.model.find(name), Bitset):
                    return None
                signed = isinstance(self.model.find(name), EnumDeclaration)
                code = CODES[wire] if signed else CODES[wire].upper()
                return [Leaf(code, slot.expression, slot.label, slot.type, None)]
            case StructNode(name):
                struct = self.model.struct(name)
                if names.mapped(struct) or not self.model.all_members(struct):
                    return None
                found: list[Leaf] = []
                for m in self.model.all_members(struct):
                    inner = Slot(
                        f"{slot.expression}.{names.member_name(m.name)}",
                        f"{struct.simple_name}.{m.name}", m.type, m.optional, m.range,
                    )  # fmt: skip
                    more = self.leaves(inner)
                    if more is None:
                        return None
                    found += more
                return found
            case _:
                return None

    def rebuilt(self, used: Type, variables: list[str], behind: list[int], label: str) -> str:
        """The value made of the next variables of a run, which are taken from the lists."""
        node = node_of(self.model, used)
        match node:
            case StructNode(name):
                struct = self.model.struct(name)
                parts = [
                    self.rebuilt(m.type, variables, behind, f"{struct.simple_name}.{m.name}")
                    for m in self.model.all_members(struct)
                ]
                return f"{names.type_name(self.model, name)}({', '.join(parts)})"
            case EnumNode(name):
                return self._enumerator(name, variables.pop(0), label, behind.pop(0))
            case _:
                behind.pop(0)
                return variables.pop(0)

    def _enumerator(self, name: str, number: str, label: str, behind: int) -> str:
        declaration = self.model.find(name)
        mine = names.type_name(self.model, name)
        if isinstance(declaration, Bitmask):
            return f'source.flags({mine}, {number}, {declaration.bit_bound}, "{label}", {behind})'
        assert isinstance(declaration, EnumDeclaration)
        default = "None"
        if declaration.default_literal is not None:
            default = f"{mine}.{names.enumerator(declaration.default_literal)}"
        return f'source.enumerator({mine}, {number}, {default}, "{label}", {behind})'

    # -- checks ------------------------------------------------------------------------------------

    def check_leaf(self, leaf: Leaf) -> list[str]:
        """Statements after a number was packed."""
        test = self._outside(leaf.access, leaf.type, leaf.limits)
        if test:
            assert leaf.limits is not None
            text = range_text(leaf.limits)
            return [
                f"if {test}:",
                f'    raise wire.out_of_range("{leaf.label}", {leaf.access}, "{text}")',
            ]
        target = self.model.target(leaf.type)
        if isinstance(target, NamedType):
            declaration = self.model.find(target.name)
            if isinstance(declaration, Bitmask) and declaration.bit_bound not in (32, 64):
                most = (1 << declaration.bit_bound) - 1
                return [
                    f"if {leaf.access} > {most}:",
                    f'    raise wire.out_of_range("{leaf.label}", {leaf.access}, "[0, {most}]")',
                ]
        return []

    def refuse_leaf(self, leaf: Leaf, variable: str, behind: int) -> list[str]:
        """Statements after a number was read."""
        test = self._outside(variable, leaf.type, leaf.limits, read=True)
        if not test:
            return []
        return [f"if {test}:", f'    source.refuse_range("{leaf.label}", {behind})']

    def _outside(self, x: str, used: Type, limits: Range | None, read: bool = False) -> str:
        target = self.model.target(used)
        if limits is None or not isinstance(target, PrimitiveType):
            return ""
        lower, upper = limits.minimum, limits.maximum
        if target.kind.is_integer:
            least, most = target.kind.integer_limits
            lower = None if lower is not None and lower <= least else lower
            upper = None if upper is not None and upper >= most else upper
        single = target.kind is Primitive.FLOAT
        lower_text, upper_text = (
            (_bound(lower, single), _bound(upper, single)) if read else (str(lower), str(upper))
        )
        if lower is None and upper is None:
            return ""
        if lower is None:
            return f"not {x} <= {upper_text}"
        if upper is None:
            return f"not {x} >= {lower_text}"
        return f"not {lower_text} <= {x} <= {upper_text}"

    # -- writing -----------------------------------------------------------------------------------

    def encode(self, slot: Slot, local: LocalNames) -> list[str]:
        """Statements that append the value to `out`."""
        limits = self.limits(slot)
        if not slot.optional:
            return self._encode(slot.type, slot.expression, slot.label, limits, local)
        x = slot.expression
        head: list[str] = []
        if "." in x:  # a name of its own, so that a type checker sees what None excludes
            x = local.fresh("value")
            head = [f"{x} = {slot.expression}"]
        inner = self._encode(slot.type, x, slot.label, limits, local)
        return [
            *head,
            f"if {x} is None:",
            '    out.append(b"\\0")',
            "else:",
            '    out.append(b"\\1")',
            *indented(inner),
        ]

    def _encode(
        self, used: Type, x: str, label: str, limits: Range | None, local: LocalNames
    ) -> list[str]:
        node = node_of(self.model, used)
        target = self.model.target(used)
        match node:
            case ScalarNode(Primitive.CHAR):
                return [f'out.append(wire.char({x}, "{label}"))']
            case ScalarNode(primitive):
                leaf = Leaf(CODES[primitive], x, label, used, limits)
                return [
                    f'out.append(wire.number({x}, "{leaf.code}", "{label}"))',
                    *self.check_leaf(leaf),
                ]
            case EnumNode(name, wire):
                declaration = self.model.find(name)
                if isinstance(declaration, Bitset):
                    return [f"out.append({x}.pack())"]
                code = CODES[wire]
                code = code if isinstance(declaration, EnumDeclaration) else code.upper()
                leaf = Leaf(code, x, label, used, None)
                return [
                    f'out.append(wire.number({x}, "{code}", "{label}"))',
                    *self.check_leaf(leaf),
                ]
            case StringNode(bound):
                return [f'out.append(wire.string({x}, {most(bound, "string")}, "{label}"))']
            case StructNode() | UnionNode(appendable=False):
                return [f"{x}.encode(out)"]
            case AppendableNode() | UnionNode():
                return [f"wire.put_block({x}, out)"]
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                limits = self.limits(Slot(x, label, target.element))
                return self._encode_sequence(
                    element, target.element, bound, x, label, limits, local
                )
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                limits = self.limits(Slot(x, label, target.element))
                return self._encode_array(
                    element, target.element, dimensions, x, label, limits, local
                )
            case MapNode(bound=bound):
                assert isinstance(target, MapType)
                key, value = local.fresh("key"), local.fresh("entry")
                inner = [
                    *self._encode(target.key, key, label, None, local),
                    *self._encode(target.value, value, label, None, local),
                ]
                return [
                    f'out.append(wire.count(len({x}), {most(bound, "count")}, "{label}"))',
                    f"for {key}, {value} in sorted({x}.items(), key=wire.first):",
                    *indented(inner),
                ]
        raise AssertionError(node)

    def _encode_sequence(
        self,
        element: Node,
        used: Type,
        bound: int | None,
        x: str,
        label: str,
        limits: Range | None,
        local: LocalNames,
    ) -> list[str]:
        limit = most(bound, "count")
        if is_octet(element):
            return [f'out += wire.octets({x}, {limit}, "{label}")']
        code = self.bulk_code(element)
        if code is not None:
            bounds = _range_arguments(limits)
            return [f'out += wire.numbers({x}, "{code}", {limit}, "{label}"{bounds})']
        item = local.fresh("item")
        return [
            f'out.append(wire.count(len({x}), {limit}, "{label}"))',
            f"for {item} in {x}:",
            *indented(self._encode(used, item, label, limits, local)),
        ]

    def _encode_array(
        self,
        element: Node,
        used: Type,
        dimensions: tuple[int, ...],
        x: str,
        label: str,
        limits: Range | None,
        local: LocalNames,
    ) -> list[str]:
        if is_octet(element) and len(dimensions) == 1:
            return [f'out.append(wire.fixed_octets({x}, {dimensions[0]}, "{label}"))']
        code = self.bulk_code(element)
        if code is not None:
            shape = ", ".join(str(d) for d in dimensions)
            bounds = _range_arguments(limits)
            return [f'out.append(wire.fixed({x}, "{code}", ({shape},), "{label}"{bounds}))']
        item = local.fresh("item" if len(dimensions) == 1 else "row")
        if len(dimensions) == 1:
            inner = self._encode(used, item, label, limits, local)
        else:
            inner = self._encode_array(element, used, dimensions[1:], item, label, limits, local)
        return [f'for {item} in wire.exactly({x}, {dimensions[0]}, "{label}"):', *indented(inner)]

    # -- reading -----------------------------------------------------------------------------------

    def decode(self, slot: Slot) -> str:
        """An expression that reads the value from `source`."""
        limits = self.limits(slot)
        text = self._decode(slot.type, slot.label, limits)
        if slot.optional:
            return f'({text} if source.number("?", "{slot.label}") else None)'
        return text

    def _decode(self, used: Type, label: str, limits: Range | None) -> str:
        node = node_of(self.model, used)
        target = self.model.target(used)
        match node:
            case ScalarNode(Primitive.CHAR):
                return f'chr(source.number("B", "{label}"))'
            case ScalarNode(primitive):
                code = CODES[primitive]
                if self._outside("x", used, limits):
                    assert limits is not None
                    single = primitive is Primitive.FLOAT
                    bounds = f"{_bound(limits.minimum, single)}, {_bound(limits.maximum, single)}"
                    return f'source.ranged("{code}", {bounds}, "{label}")'
                return f'source.number("{code}", "{label}")'
            case EnumNode(name, wire):
                declaration = self.model.find(name)
                if isinstance(declaration, Bitset):
                    return f'{names.type_name(self.model, name)}.unpack(source, "{label}")'
                signed = isinstance(declaration, EnumDeclaration)
                code = CODES[wire] if signed else CODES[wire].upper()
                number = f'source.number("{code}", "{label}")'
                return self._enumerator(name, number, label, wire.size)
            case StringNode(bound):
                return f'source.string({most(bound, "count")}, "{label}")'
            case StructNode(name) | UnionNode(name, False):
                return f"{names.type_name(self.model, name)}.decode(source)"
            case AppendableNode(name) | UnionNode(name):
                return f'{names.type_name(self.model, name)}.decode(source.block("{label}"))'
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                limits = self.limits(Slot("", label, target.element))
                least = min_size_of(self.model, element)
                count = f'source.count({least}, {most(bound, "count")}, "{label}")'
                return self._decode_elements(element, target.element, count, label, limits)
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                limits = self.limits(Slot("", label, target.element))
                return self._decode_array(element, target.element, dimensions, label, limits)
            case MapNode(key, value, bound):
                assert isinstance(target, MapType)
                least = min_size_of(self.model, key) + min_size_of(self.model, value)
                read_key = self._decode(target.key, label, None)
                read_value = self._decode(target.value, label, None)
                return (
                    f"source.mapping(lambda: {read_key}, lambda: {read_value}, "
                    f'{least}, {most(bound, "count")}, "{label}")'
                )
        raise AssertionError(node)

    def _decode_elements(
        self, element: Node, used: Type, count: str, label: str, limits: Range | None
    ) -> str:
        if is_octet(element):
            return f'source.octets({count}, "{label}")'
        code = self.bulk_code(element)
        if code is not None:
            return f'source.array("{code}", {count}, "{label}"{_range_arguments(limits)})'
        return f"[{self._decode(used, label, limits)} for _ in range({count})]"

    def _decode_array(
        self,
        element: Node,
        used: Type,
        dimensions: tuple[int, ...],
        label: str,
        limits: Range | None,
    ) -> str:
        if is_octet(element) and len(dimensions) == 1:
            return f'source.octets({dimensions[0]}, "{label}")'
        code = self.bulk_code(element)
        if code is not None:
            total = 1
            for size in dimensions:
                total *= size
            text = f'source.array("{code}", {total}, "{label}"{_range_arguments(limits)})'
            shape = ", ".join(str(d) for d in dimensions)
            return f"{text}.reshape({shape})" if len(dimensions) > 1 else text
        text = self._decode(used, label, limits)
        for size in reversed(dimensions):
            text = f"[{text} for _ in range({size})]"
        return text

    def imports(self, used: Type) -> set[str]:
        """Scoped names of the declared types that a value's codec and hint name."""
        match used:
            case NamedType(name):
                declaration = self.model.find(name)
                if isinstance(declaration, Typedef):
                    return self.imports(declaration.type)
                if isinstance(declaration, Struct) and not names.mapped(declaration):
                    opened = self.leaves(Slot("", "", used))
                    inner: set[str] = {name}
                    if opened:
                        for m in self.model.all_members(declaration):
                            inner |= self.imports(m.type)
                    return inner
                if isinstance(declaration, Union):
                    return {name}
                return {name}
            case SequenceType(element) | ArrayType(element):
                return self.imports(element)
            case MapType(key, value):
                return self.imports(key) | self.imports(value)
            case _:
                return set()


def is_octet(element: Node) -> bool:
    return isinstance(element, ScalarNode) and element.primitive is Primitive.OCTET


def most(bound: int | None, what: str) -> str:
    if bound is not None:
        return str(bound)
    return "wire.MAX_TEXT" if what == "string" else "wire.MAX_COUNT"


def indented(lines: list[str]) -> list[str]:
    return [f"    {line}" for line in lines]


def quoted(text: str) -> str:
    """A string literal in double quotes, as ruff writes them."""
    body = repr(text)[1:-1] if "'" not in text else repr(text)[1:-1].replace("\\'", "'")
    if repr(text).startswith('"'):
        return repr(text)
    return '"' + body.replace('"', '\\"') + '"'


def _bound(value: int | float | None, single: bool) -> str:
    """A bound as readers compare it: that of single precision is rounded like the number."""
    if value is None or not single:
        return str(value)
    import struct

    return repr(struct.unpack("f", struct.pack("f", value))[0])


def _range_arguments(limits: Range | None) -> str:
    return "" if limits is None else f", {limits.minimum}, {limits.maximum}"
