"""Types and codecs in C++: what a value is called, how large it is, how it is written and read.

Sizes, writing and checking are statements, a list of lines each. Reading is one boolean expression,
so that fields chain with && and the first refusal ends it; composed values pass a lambda to the
functions of gecos/wire/fields.hpp.
"""

from __future__ import annotations

from dataclasses import dataclass

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
from gidl.targets.cpp import names
from gidl.targets.naming import LocalNames, escaped, range_text, within
from gidl.wire_layout import Layout, min_size_of, node_of
from gidl.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    MapNode,
    Node,
    OptionalNode,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
    UnionNode,
)

PRIMITIVES = {
    Primitive.BOOLEAN: "bool", Primitive.OCTET: "std::uint8_t", Primitive.CHAR: "char",
    Primitive.INT8: "std::int8_t", Primitive.UINT8: "std::uint8_t",
    Primitive.INT16: "std::int16_t", Primitive.UINT16: "std::uint16_t",
    Primitive.INT32: "std::int32_t", Primitive.UINT32: "std::uint32_t",
    Primitive.INT64: "std::int64_t", Primitive.UINT64: "std::uint64_t",
    Primitive.FLOAT: "float", Primitive.DOUBLE: "double",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Slot:
    """A value with a place: a member, a parameter, a result. `label` is what messages call it."""

    expression: str
    label: str
    type: Type
    optional: bool = False
    range: Range | None = None


class Lowering:
    def __init__(self, model: Model, layout: Layout) -> None:
        self.model = model
        self.layout = layout
        self._checked: dict[str, bool] = {}

    # -- types and values ------------------------------------------------------------------------

    def type(self, used: Type, optional: bool = False) -> str:
        if optional:
            return f"std::optional<{self.type(used)}>"
        match used:
            case PrimitiveType(kind):
                return PRIMITIVES[kind]
            case StringType():
                return "std::string"
            case SequenceType(element):
                return f"std::vector<{self.type(element)}>"
            case MapType(key, value):
                return f"std::map<{self.type(key)}, {self.type(value)}>"
            case ArrayType(element, dimensions):
                text = self.type(element)
                for size in reversed(dimensions):
                    text = f"std::array<{text}, {size}>"
                return text
            case NamedType(name):
                return names.full_name(self.model, name)

    def parameter(self, used: Type, optional: bool = False) -> str:
        """How a function takes it: small ones as they are."""
        text = self.type(used, optional)
        target = self.model.target(used)
        small = isinstance(target, PrimitiveType)
        if isinstance(target, NamedType):
            small = isinstance(self.model.find(target.name), EnumDeclaration | Bitmask)
        return text if small and not optional else f"const {text}&"

    def literal(self, value: Value, used: Type) -> str:
        match value:
            case EnumValue(enum, literal):
                return f"{names.full_name(self.model, enum)}::{escaped(literal, names.KEYWORDS)}"
            case bool():
                return "true" if value else "false"
            case str():
                target = self.model.target(used)
                is_char = target == PrimitiveType(Primitive.CHAR)
                return _quoted(value, "'" if is_char else '"')
            case _:
                return self._number(value, used)

    def _number(self, value: int | float, used: Type) -> str:
        target = self.model.target(used)
        kind = target.kind if isinstance(target, PrimitiveType) else Primitive.INT64
        if kind is Primitive.FLOAT:
            return f"{float(value)!r}F"
        if kind is Primitive.DOUBLE:
            return repr(float(value))
        if kind.is_unsigned:
            return f"{value}U"
        if value == -(1 << 63):
            return "std::numeric_limits<std::int64_t>::min()"
        return str(value)

    def initial(self, member: Member) -> str:
        """What stands behind a member's name: " = 1.0" or "{}".

        Never nothing: only so may a program name some members of a struct and leave the others out
        (`Trajectory{.speed = 0.5}`) under -Wextra.
        """
        if member.optional:
            return "{}"
        if member.default is not None:
            return f" = {self.literal(member.default, member.type)}"
        target = self.model.target(member.type)
        if isinstance(target, PrimitiveType):
            zero = {Primitive.BOOLEAN: "false", Primitive.CHAR: "'\\0'"}.get(target.kind, "0")
            return f" = {zero}"
        if isinstance(target, NamedType):
            declaration = self.model.find(target.name)
            if isinstance(declaration, EnumDeclaration):
                enum = names.full_name(self.model, declaration.name)
                return f" = {enum}::{escaped(declaration.initial.name, names.KEYWORDS)}"
        return "{}"

    # -- size --------------------------------------------------------------------------------------

    def size(self, slot: Slot, total: str, local: LocalNames) -> tuple[int, list[str]]:
        """Bytes that are always there, and statements that add the others to `total`."""
        node = node_of(self.model, slot.type, slot.optional)
        return self._size(node, slot.expression, total, local)

    def _size(self, node: Node, x: str, total: str, local: LocalNames) -> tuple[int, list[str]]:
        match node:
            case ScalarNode() | EnumNode():
                return min_size_of(self.model, node), []
            case StringNode():
                return 5, [f"{total} += {call(x, 'size()')};"]
            case StructNode(name):
                fixed = self.layout.structs[name].fixed_size
                if fixed is not None:
                    return fixed, []
                return 0, [f"{total} += {call(x, 'encoded_size()')};"]
            case AppendableNode() | UnionNode(appendable=True):
                return 4, [f"{total} += {call(x, 'encoded_size()')};"]
            case UnionNode():
                return 0, [f"{total} += {call(x, 'encoded_size()')};"]
            case ArrayNode(element, dimensions):
                item = local.fresh("item")
                each, lines = self._size(element, item, total, local)
                if not lines:
                    return each * node.count, []
                for _ in dimensions[1:]:
                    outer = local.fresh("row")
                    lines = loop(item, outer, lines)
                    item = outer
                return each * node.count, loop(item, x, lines)
            case SequenceNode(element=element):
                item = local.fresh("item")
                each, lines = self._size(element, item, total, local)
                return 4, self._repeated(x, each, lines, total, loop(item, x, lines))
            case OptionalNode(element=element):
                each, lines = self._size(element, f"*{x}", total, local)
                if each:
                    lines = [f"{total} += {each};", *lines]
                return 1, block(f"if ({x})", lines)
            case MapNode(key, value):
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                key_size, key_lines = self._size(key, key_name, total, local)
                each, lines = self._size(value, value_name, total, local)
                inner = [*key_lines, *lines]
                whole = block(f"for (const auto& [{key_name}, {value_name}] : {x})", inner)
                return 4, self._repeated(x, key_size + each, inner, total, whole)
            case _:
                raise AssertionError(node)

    @staticmethod
    def _repeated(x: str, each: int, inner: list[str], total: str, whole: list[str]) -> list[str]:
        lines = [f"{total} += {each} * {call(x, 'size()')};"] if each else []
        return lines + (whole if inner else [])

    # -- writing -----------------------------------------------------------------------------------

    def encode(self, slot: Slot, to: str, local: LocalNames) -> list[str]:
        node = node_of(self.model, slot.type, slot.optional)
        return self._encode(node, slot.expression, to, local)

    def _encode(self, node: Node, x: str, to: str, local: LocalNames) -> list[str]:
        match node:
            case ScalarNode():
                return [f"{to}.put({x});"]
            case EnumNode(name, wire):
                if isinstance(self.model.find(name), Bitset):
                    return [f"{to}.put({call(x, 'bits()')});"]
                return [f"{to}.put(static_cast<{PRIMITIVES[wire]}>({x}));"]
            case StringNode():
                return [f"{to}.put_string({x});"]
            case StructNode() | UnionNode(appendable=False):
                return [f"{call(x, f'encode({to})')};"]
            case AppendableNode() | UnionNode():
                size = call(x, "encoded_size()")
                return [f"{to}.put_count({size});", f"{call(x, f'encode({to})')};"]
            case ArrayNode(element, dimensions):
                return self._encode_array(element, len(dimensions), x, to, local)
            case SequenceNode(element=element):
                lines = self._encode_array(element, 1, x, to, local)
                return [f"{to}.put_count({call(x, 'size()')});", *lines]
            case OptionalNode(element=element):
                inner = self._encode(element, f"*{x}", to, local)
                return [f"{to}.put({call(x, 'has_value()')});", *block(f"if ({x})", inner)]
            case MapNode(key, value):
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                inner = [
                    *self._encode(key, key_name, to, local),
                    *self._encode(value, value_name, to, local),
                ]
                head = f"for (const auto& [{key_name}, {value_name}] : {x})"
                return [f"{to}.put_count({call(x, 'size()')});", *block(head, inner)]
            case _:
                raise AssertionError(node)

    def _encode_array(
        self, element: Node, depth: int, x: str, to: str, local: LocalNames
    ) -> list[str]:
        if depth == 1 and is_bulk(element):
            return [f"{to}.put_array({x});"]
        item = local.fresh("item" if depth == 1 else "row")
        if depth == 1:
            inner = self._encode(element, item, to, local)
        else:
            inner = self._encode_array(element, depth - 1, item, to, local)
        boolean = depth == 1 and element == ScalarNode(Primitive.BOOLEAN)
        return loop(item, x, inner, "const bool" if boolean else "const auto&")

    # -- reading -----------------------------------------------------------------------------------

    def decode(self, slot: Slot, source: str, local: LocalNames) -> list[str]:
        """Lines of a boolean expression."""
        node = node_of(self.model, slot.type, slot.optional)
        limits = self.limits(slot)
        return self._decode(node, slot.type, slot.expression, slot.label, source, local, limits)

    def limits(self, slot: Slot) -> Range | None:
        """Bounds of a number, those of its typedefs included."""
        limits, used = slot.range, slot.type
        while isinstance(used, NamedType):
            declaration = self.model.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            limits, used = within(limits, declaration.range), declaration.type
        return limits

    def _decode(
        self,
        node: Node,
        used: Type,
        x: str,
        label: str,
        source: str,
        local: LocalNames,
        limits: Range | None = None,
    ) -> list[str]:
        field = f'"{label}"'
        target = self.model.target(used)
        match node:
            case OptionalNode(element=element):
                inner_name = local.fresh("value")
                inner = self._decode(element, used, inner_name, label, source, local, limits)
                head = f"gecos::wire::get_optional({source}, {x}, {field}, "
                return with_lambda(head, self.type(used), inner_name, inner)
            case ScalarNode(primitive):
                lines = [f"{source}.get({x}, {field})"]
                test = range_test(x, primitive, limits)
                if test:
                    size = primitive.size
                    lines[0] += " &&"
                    lines.append(f"gecos::wire::in_range({source}, {test}, {size}, {field})")
                return lines
            case EnumNode(name):
                scope = "::".join(names.scope_of(self.model, name))
                prefix = f"{scope}::" if scope else "::"
                return [f"{prefix}decode_enum({source}, {x}, {field})"]
            case StringNode(bound):
                return [f"{source}.get_string({x}, {_bound(bound)}, {field})"]
            case StructNode() | UnionNode(appendable=False):
                return [call(x, f"decode({source})")]
            case AppendableNode() | UnionNode():
                return [f"gecos::wire::get_block({source}, {x}, {field})"]
            case ArrayNode(element, dimensions):
                assert isinstance(target, ArrayType)
                return self._decode_array(
                    element, target.element, dimensions, x, label, source, local
                )
            case SequenceNode(element, bound):
                assert isinstance(target, SequenceType)
                if is_bulk(element):
                    bulk = f"gecos::wire::get_numbers({source}, {x}, {_bound(bound)}, {field})"
                    return [bulk]
                item = local.fresh("item")
                limits = self.limits(Slot(item, label, target.element))
                inner = self._decode(element, target.element, item, label, source, local, limits)
                least = min_size_of(self.model, element)
                head = (
                    f"gecos::wire::get_sequence({source}, {x}, {least}, {_bound(bound)}, {field}, "
                )
                return with_lambda(head, self.type(target.element), item, inner)
            case MapNode(key, value, bound):
                assert isinstance(target, MapType)
                least = min_size_of(self.model, key) + min_size_of(self.model, value)
                key_name, value_name = local.fresh("key"), local.fresh("entry")
                key_lines = self._decode(key, target.key, key_name, label, source, local)
                lines = self._decode(value, target.value, value_name, label, source, local)
                head = f"gecos::wire::get_map({source}, {x}, {least}, {_bound(bound)}, {field}, "
                first = with_lambda(head, self.type(target.key), key_name, key_lines)
                first[-1] = first[-1].removesuffix(")") + ","
                second = with_lambda("", self.type(target.value), value_name, lines)
                return [*first, *indented(second)]
            case _:
                raise AssertionError(node)

    def _decode_array(
        self,
        element: Node,
        used: Type,
        dimensions: tuple[int, ...],
        x: str,
        label: str,
        source: str,
        local: LocalNames,
    ) -> list[str]:
        if len(dimensions) == 1 and is_bulk(element):
            return [f'{source}.get_array({x}, "{label}")']
        item = local.fresh("item" if len(dimensions) == 1 else "row")
        if len(dimensions) == 1:
            item_type = self.type(used)
            inner = self._decode(element, used, item, label, source, local)
        else:
            item_type = self.type(ArrayType(used, dimensions[1:]))
            inner = self._decode_array(element, used, dimensions[1:], item, label, source, local)
        return with_lambda(f"gecos::wire::get_each({x}, ", item_type, item, inner)

    # -- checks before sending ---------------------------------------------------------------------

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
                case Union() | Bitset():
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


def range_test(x: str, kind: Primitive, limits: Range | None) -> str:
    """ "(x >= 0.01 && x <= 1.0)"; NaN is never inside. Empty where every value is."""
    if limits is None or not kind.is_number:
        return ""
    tests = []
    for sign, bound in ((">=", limits.minimum), ("<=", limits.maximum)):
        if bound is None:
            continue
        if kind.is_integer:
            least, most = kind.integer_limits
            if (sign == ">=" and bound <= least) or (sign == "<=" and bound >= most):
                continue
            text = f"{int(bound)}{'U' if kind.is_unsigned else ''}"
        else:
            text = f"{float(bound)!r}{'F' if kind is Primitive.FLOAT else ''}"
        tests.append(f"{x} {sign} {text}")
    return f"({' && '.join(tests)})" if tests else ""


def is_bulk(element: Node) -> bool:
    """Numbers that are swapped in bulk: every scalar but booleans."""
    return isinstance(element, ScalarNode) and element.primitive is not Primitive.BOOLEAN


def call(x: str, what: str) -> str:
    return f"{x[1:]}->{what}" if x.startswith("*") else f"{x}.{what}"


def indented(lines: list[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def block(head: str, lines: list[str]) -> list[str]:
    return [f"{head} {{", *indented(lines), "}"]


def loop(item: str, over: str, lines: list[str], kind: str = "const auto&") -> list[str]:
    return block(f"for ({kind} {item} : {over})", lines) if lines else []


def with_lambda(head: str, parameter: str, name: str, body: list[str]) -> list[str]:
    """`head` with a lambda behind it whose body is the expression `body`."""
    first, *rest = body
    lines = [f"return {first}", *rest]
    lines[-1] += ";"
    short = len(lines) == 1 and len(head) + len(parameter) + len(lines[0]) < 80
    if short:
        return [f"{head}[&]({parameter}& {name}) {{ {lines[0]} }})"]
    return [f"{head}[&]({parameter}& {name}) {{", *indented(lines), "})"]


def _bound(bound: int | None) -> str:
    return "gecos::wire::npos" if bound is None else str(bound)


_ESCAPES = {"\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t", "\0": "\\0"}


def _quoted(text: str, quote: str) -> str:
    out = ""
    for letter in text:
        if letter == quote:
            out += f"\\{quote}"
        elif letter in _ESCAPES:
            out += _ESCAPES[letter]
        elif " " <= letter <= "~":
            out += letter
        else:
            out += "".join(f"\\{byte:03o}" for byte in letter.encode("utf-8"))
    return f"{quote}{out}{quote}"
