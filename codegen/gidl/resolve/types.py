"""Resolves declarations of types and constants: turns their syntax into declarations of the
model."""

from __future__ import annotations

from collections.abc import Sequence

from gidl.diagnostics.findings import Findings, Note
from gidl.diagnostics.source import Span
from gidl.model import (
    AnyDeclaration,
    ArrayType,
    Bitfield,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    Enumerator,
    EnumValue,
    ExceptionStruct,
    Extensibility,
    Facts,
    Flag,
    MapsTo,
    MapType,
    Member,
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
    UnionCase,
    Value,
    within,
)
from gidl.resolve.constants import computed, is_character
from gidl.resolve.quantities import cpp_type, python_type
from gidl.resolve.scopes import Names, Scope, Symbol
from gidl.resolve.values import Marks, ValueResolver
from gidl.resolve.vocabulary import Applied, Vocabulary
from gidl.syntax.tree import (
    BasicType,
    BitfieldSyntax,
    BitmaskSyntax,
    BitsetSyntax,
    ConstSyntax,
    DeclarationSyntax,
    EnumSyntax,
    ForwardSyntax,
    InlineType,
    MemberSyntax,
    ScopedName,
    StructSyntax,
    TypedefSyntax,
    TypeSyntax,
    UnionSyntax,
)

_STRUCT = frozenset(("struct",))
_BITSET = frozenset(("bitset",))


class TypeResolver(ValueResolver):
    """Each method declares and resolves one declaration, and appends the result to `_out`."""

    def __init__(self, findings: Findings, names: Names, vocabulary: Vocabulary) -> None:
        super().__init__(findings, names, vocabulary)
        self._out: list[AnyDeclaration] = []
        # Unit and range of each typedef, by its scoped name.
        self._of_typedef: dict[str, tuple[str | None, Range | None]] = {}
        self._bitset_sizes: dict[str, int] = {}
        self._enums: dict[str, EnumDeclaration] = {}
        self._bitmasks: set[str] = set()

    def _type_declaration(self, syntax: DeclarationSyntax, scope: Scope) -> bool:
        """Resolves `syntax` if it declares a type or a constant. Returns whether it does."""
        match syntax:
            case StructSyntax():
                self._struct(syntax, scope)
            case UnionSyntax():
                self._union(syntax, scope)
            case EnumSyntax():
                self._enum(syntax, scope)
            case BitmaskSyntax():
                self._bitmask(syntax, scope)
            case BitsetSyntax():
                self._bitset(syntax, scope)
            case TypedefSyntax():
                self._typedef(syntax, scope)
            case ConstSyntax():
                self._const(syntax, scope)
            case ForwardSyntax():
                self._names.forward(scope, syntax.name, syntax.kind)
            case _:
                return False
        return True

    def _declared_inline(self, syntax: InlineType, scope: Scope) -> NamedType | None:
        """Resolves a type that is declared inside another declaration. In the model, the type
        becomes a declaration of its own, before the enclosing one."""
        self._type_declaration(syntax.declaration, scope)
        symbol = scope.symbols.get(syntax.declaration.name.text.lower())
        if symbol is None or symbol.span != syntax.declaration.name.span:
            return None
        return NamedType(symbol.scoped)

    def _keep(self, symbol: Symbol | None, declaration: AnyDeclaration) -> None:
        """Adds a declaration to the model. If `symbol` is None, the name was declared before, and
        this second declaration is left out."""
        if symbol is not None:
            self._out.append(declaration)

    # -- struct, exception ---------------------------------------------------------------------

    def _struct(self, syntax: StructSyntax, scope: Scope) -> None:
        kind = "exception" if syntax.is_exception else "struct"
        marks = self._marks(syntax.extras, kind, scope)
        base = None
        if syntax.base is not None:
            base = self._complete(syntax.base, scope, _STRUCT, "struct")
        symbol = self._names.declare(scope, syntax.name, kind)
        inside = Scope(scope.qualified(syntax.name.text), kind, scope)
        if symbol is not None:
            symbol.scope = inside
        members = self._members(syntax.members, inside)
        made = ExceptionStruct if syntax.is_exception else Struct
        self._keep(
            symbol,
            made(
                inside.name,
                self._facts(syntax.name, syntax.extras, marks),
                members,
                base,
                self._extensibility(marks),
                self._maps_to(marks),
            ),
        )

    def _complete(
        self, name: ScopedName, scope: Scope, kinds: frozenset[str], what: str
    ) -> str | None:
        """Returns the scoped name of the declaration that `name` means, with typedefs resolved. If
        the declaration is incomplete, or its kind is not in `kinds`, adds a finding and returns
        None."""
        symbol = self._symbol(name, scope, kinds | {"typedef"}, what, "G0102")
        if symbol is not None and symbol.kind == "typedef":
            symbol = self._behind(name, symbol, scope, kinds, what)
        if symbol is None:
            return None
        if not self._names.is_complete(symbol):
            self._findings.error(
                "G0111",
                name.span,
                f"{what} '{name}' has only a forward declaration before this use",
                f"move the full declaration of the {what} before this use",
                notes=(Note("declared forward here", symbol.span.location),),
            )
            self._used_incomplete.add(symbol.scoped)
            return None
        return symbol.scoped

    def _behind(self, name: ScopedName, typedef: Symbol, scope: Scope, kinds: frozenset[str],
                what: str) -> Symbol | None:  # fmt: skip
        """Returns the symbol of the type that `typedef` stands for. If the kind of this type is not
        in `kinds`, adds a finding and returns None."""
        target = self._target(NamedType(typedef.scoped))
        symbol = self._names.declared(target.name) if isinstance(target, NamedType) else None
        if symbol is None or symbol.kind not in kinds:
            self._wrong_kind(name, typedef, scope, kinds, what)
            return None
        return symbol

    def _members(self, members: Sequence[MemberSyntax], scope: Scope) -> tuple[Member, ...]:
        found: list[Member] = []
        for member in members:
            found.extend(self._member(member, scope))
        return tuple(found)

    def _member(self, syntax: MemberSyntax, scope: Scope) -> list[Member]:
        marks = self._marks(syntax.extras, "member", scope)
        used = self._type(syntax.type, scope)
        self._check_complete(used, syntax.type, in_sequences=False)
        found = []
        for declarator in syntax.declarators:
            symbol = self._names.declare(scope, declarator.name, "member")
            if used is None:
                continue
            full = self._with_dimensions(used, declarator, scope)
            if full is None or symbol is None:
                continue
            found.append(
                Member(
                    declarator.name.text,
                    full,
                    self._facts(declarator.name, syntax.extras, marks),
                    self._unit(marks, full),
                    self._range(marks, full),
                    self._default(marks, full),
                    marks.flag("optional"),
                    marks.number("id"),
                    "bulk" in marks,
                    "secret" in marks,
                )
            )
        return found

    def _extensibility(self, marks: Marks) -> Extensibility:
        refused = marks.get("mutable")
        if refused is not None:
            self._findings.error(
                "G0214",
                refused.span,
                "'@mutable' is not part of .gidl",
                "use @appendable, which allows new members at the end",
            )
        final, appendable = marks.get("final"), marks.get("appendable")
        if final is not None and appendable is not None:
            self._findings.error(
                "G0505",
                max(final.span, appendable.span, key=lambda span: span.start),
                "'@final' and '@appendable' contradict each other",
                "write only one of these annotations",
            )
        return Extensibility.APPENDABLE if "appendable" in marks else Extensibility.FINAL

    def _maps_to(self, marks: Marks) -> MapsTo | None:
        applied = marks.get("maps_to")
        if applied is None:
            return None
        cpp, python = applied.text("cpp"), applied.text("python")
        cpp_found, python_found = cpp_type(cpp), python_type(python)
        if (cpp and cpp_found is None) or (python and python_found is None):
            self._findings.error(
                "G0506",
                applied.span,
                "'@maps_to' needs the name of a type",
                'write cpp="ns::Type <path/header.hpp>" and python="package.module:Class"',
            )
        return MapsTo(cpp_found, python_found)

    def _unit(self, marks: Marks, used: Type) -> str | None:
        own = marks.text("unit")
        if own is not None:
            return own
        return self._from_typedef(used)[0]

    def _from_typedef(self, used: Type) -> tuple[str | None, Range | None]:
        """Returns the unit and the range that `used` declares if it is a typedef, else (None,
        None)."""
        name = used.name if isinstance(used, NamedType) else ""
        return self._of_typedef.get(name, (None, None))

    def _range(self, marks: Marks, used: Type) -> Range | None:
        """Returns the range that the annotations declare for a value of the type `used`, narrowed
        by the ranges of the typedefs in this type. The range of an array or a sequence applies to
        its elements."""
        both, low, high = marks.get("range"), marks.get("min"), marks.get("max")
        written = both or low or high
        if written is None:
            return self._from_typedef(used)[1]
        if both is not None and (low or high):
            self._findings.error(
                "G0505",
                both.span,
                "'@range' means the same as '@min' and '@max': write either '@range', or "
                "'@min' and '@max'",
            )
        target, inherited = self._bounded(used)
        if not (isinstance(target, PrimitiveType) and target.kind.is_number):
            hint = ""
            if isinstance(target, MapType):
                hint = (
                    "declare a typedef with the range, and use it as the type of the keys or values"
                )
            self._findings.error(
                "G0307", written.span, f"'@{written.name}' can only limit a number", hint
            )
            return None
        least = self._limit(both or low, "min" if both else "value", target)
        most = self._limit(both or high, "max" if both else "value", target)
        if least is not None and most is not None and least > most:
            self._findings.error(
                "G0307", written.span, f"no number is between {least} and {most}", "swap the bounds"
            )
            return None
        both_ranges = within(Range(least, most), inherited)
        assert both_ranges is not None
        least, most = both_ranges.minimum, both_ranges.maximum
        if least is not None and most is not None and least > most:
            self._findings.error(
                "G0307",
                written.span,
                f"no value is in both this range and the type's range: {least} is above {most}",
                "the range must be within the range of the typedef",
            )
            return None
        return both_ranges

    def _bounded(self, used: Type) -> tuple[Type, Range | None]:
        """Returns the type of the numbers that a range on `used` limits: for arrays and sequences,
        this is the type of the elements. Also returns the range that the typedefs of `used` and of
        its elements declare."""
        inherited = self._from_typedef(used)[1]
        target = self._target(used)
        while isinstance(target, ArrayType | SequenceType):
            inherited = within(inherited, self._from_typedef(target.element)[1])
            target = self._target(target.element)
        return target, inherited

    def _limit(self, applied: Applied | None, argument: str, target: Type) -> int | float | None:
        """Returns the limit that an argument of @range, @min or @max sets for numbers of the type
        `target`. Returns None without a limit, or after a finding."""
        if applied is None:
            return None
        limit = applied.computed(argument)
        if limit.kind not in ("int", "float"):
            self._findings.error("G0307", applied.span, "a limit of this range is not a number")
            return None
        fitted = self._fit(limit, target, applied.span)
        return fitted if isinstance(fitted, int | float) else None

    def _default(self, marks: Marks, used: Type) -> Value | None:
        applied = marks.get("default")
        if applied is None:
            return None
        value = applied.arguments["value"]
        target = self._target(used)
        if isinstance(target, NamedType) or isinstance(value, EnumValue):
            self._findings.error(
                "G0308",
                applied.span,
                "'@default' takes a number, boolean, character or string",
                "write '@default_literal' before one enumerator of the enum"
                if isinstance(value, EnumValue) or not isinstance(target, NamedType)
                else "members of this type get the defaults that the type declares",
            )
            return None
        if target == PrimitiveType(Primitive.CHAR) and is_character(value):
            return value
        return self._fit(applied.computed(), target, applied.span)

    # -- union ---------------------------------------------------------------------------------

    def _union(self, syntax: UnionSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "union", scope)
        symbol = self._names.declare(scope, syntax.name, "union")
        inside = Scope(scope.qualified(syntax.name.text), "union", scope)
        if symbol is not None:
            symbol.scope = inside
        used = self._type(syntax.discriminator, inside)
        labels_scope = Scope(inside.name, "operation", scope, dict(inside.symbols))
        discriminator = None if used is None else self._target(used)
        if discriminator is not None and not _may_discriminate(discriminator, self._enums):
            self._findings.error(
                "G0312",
                syntax.discriminator.span,
                "the discriminator of a union must be an integer, boolean, char, octet or enum",
            )
            discriminator = None
        if used is not None and discriminator is not None:
            self._refuse_ranged_discriminator(used, syntax.discriminator)
        cases = []
        for case in syntax.cases:
            labels: list[Value] = []
            for label in case.labels:
                if discriminator is not None:
                    value = self._typed_value(label, discriminator, labels_scope)
                    if value is not None:
                        labels.append(value)
            members = self._member(case.member, inside)
            if len(case.member.declarators) > 1:
                second = case.member.declarators[1].name
                self._findings.error(
                    "G0313",
                    second.span,
                    "a case of a union can have only one member, but this case has several",
                    "write a case for each member, or use a struct",
                )
            if members:
                cases.append(UnionCase(tuple(labels), case.default is not None, members[0]))
        if isinstance(discriminator, PrimitiveType | NamedType):
            self._keep(
                symbol,
                Union(
                    inside.name,
                    self._facts(syntax.name, syntax.extras, marks),
                    discriminator,
                    tuple(cases),
                    self._extensibility(marks),
                ),
            )
        elif symbol is not None:
            number = PrimitiveType(Primitive.INT32)
            facts = self._facts(syntax.name, syntax.extras, marks)
            self._keep(symbol, Union(inside.name, facts, number, ()))

    def _refuse_ranged_discriminator(self, used: Type, syntax: TypeSyntax) -> None:
        if self._from_typedef(used)[1] is not None:
            self._findings.error(
                "G0312",
                syntax.span,
                "the discriminator of a union cannot have a range",
                "use the type without a range; a union has no member if no case names the value of "
                "the discriminator",
            )

    # -- enum, bitmask, bitset -----------------------------------------------------------------

    def _enum(self, syntax: EnumSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "enum", scope)
        symbol = self._names.declare(scope, syntax.name, "enum")
        scoped = scope.qualified(syntax.name.text)
        enumerators: list[Enumerator] = []
        default: str | None = None
        number = -1
        for item in syntax.items:
            inner = self._marks(item.extras, "enumerator", scope)
            own = inner.get("value")
            number += 1
            if own is not None:
                fitted = self._fit(
                    computed(own.arguments["value"]), PrimitiveType(Primitive.INT32), own.span
                )
                number = fitted if isinstance(fitted, int) else number
            if "default_literal" in inner:
                if default is not None:
                    self._findings.error(
                        "G0505",
                        item.name.span,
                        f"enumerator '{default}' already has '@default_literal'",
                    )
                default = item.name.text
            declared = self._names.declare(scope, item.name, "enumerator")
            if declared is None:
                continue
            declared.value = EnumValue(scoped, item.name.text, number)
            facts = self._facts(item.name, item.extras, inner)
            enumerators.append(Enumerator(item.name.text, number, facts))
        self._extensibility(marks)
        facts = self._facts(syntax.name, syntax.extras, marks)
        enum = EnumDeclaration(
            scoped, facts, tuple(enumerators), default, self._bit_bound(marks, 32)
        )
        self._enums[scoped] = enum
        self._keep(symbol, enum)

    def _bit_bound(self, marks: Marks, most: int) -> int:
        applied = marks.get("bit_bound")
        if applied is None:
            return 32
        bound = marks.number("bit_bound") or 0
        if not 1 <= bound <= most:
            self._findings.error(
                "G0309", applied.span, f"'@bit_bound' must be from 1 to {most} here"
            )
            return 32
        return bound

    def _bitmask(self, syntax: BitmaskSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "bitmask", scope)
        symbol = self._names.declare(scope, syntax.name, "bitmask")
        inside = Scope(scope.qualified(syntax.name.text), "bitmask", scope)
        flags: list[Flag] = []
        position = -1
        for item in syntax.items:
            inner = self._marks(item.extras, "flag", scope)
            own = inner.number("position")
            position = position + 1 if own is None else own
            declared = self._names.declare(inside, item.name, "flag")
            if declared is None:
                continue
            declared.value = EnumValue(inside.name, item.name.text, 1 << position)
            facts = self._facts(item.name, item.extras, inner)
            flags.append(Flag(item.name.text, position, facts))
        if symbol is not None:
            symbol.scope = inside
            self._bitmasks.add(inside.name)
        self._extensibility(marks)
        facts = self._facts(syntax.name, syntax.extras, marks)
        bound = self._bit_bound(marks, 64)
        self._keep(symbol, Bitmask(inside.name, facts, tuple(flags), bound))

    def _bitset(self, syntax: BitsetSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "bitset", scope)
        base = None
        if syntax.base is not None:
            base = self._complete(syntax.base, scope, _BITSET, "bitset")
        symbol = self._names.declare(scope, syntax.name, "bitset")
        inside = Scope(scope.qualified(syntax.name.text), "bitset", scope)
        position = self._bitset_sizes.get(base, 0) if base else 0
        fields: list[Bitfield] = []
        for field in syntax.fields:
            width = self._size(field.width, scope, "the width of a bitfield", 64)
            if width is None:
                continue
            used = self._bitfield_type(field, width)
            inner = self._marks(field.extras, "bitfield", scope)
            if not field.names:
                facts = Facts(field.span.location, field.extras.doc)
                fields.append(Bitfield(None, position, width, used, facts))
                position += width
            for name in field.names:
                if self._names.declare(inside, name, "bitfield") is not None:
                    facts = self._facts(name, field.extras, inner)
                    fields.append(Bitfield(name.text, position, width, used, facts))
                position += width
        if symbol is not None:
            self._bitset_sizes[inside.name] = position
        self._extensibility(marks)
        facts = self._facts(syntax.name, syntax.extras, marks)
        self._keep(symbol, Bitset(inside.name, facts, tuple(fields), base, position))

    def _bitfield_type(self, field: BitfieldSyntax, width: int) -> PrimitiveType:
        """Returns the declared type of a bitfield. A bitfield without a declared type is boolean if
        it has one bit, else the smallest unsigned integer that is wide enough."""
        if isinstance(field.type, BasicType):
            kind = Primitive(field.type.name)
            if not (kind.is_integer or kind is Primitive.BOOLEAN):
                self._findings.error(
                    "G0311", field.type.span, "a bitfield must be boolean, octet or an integer"
                )
            else:
                room = 1 if kind is Primitive.BOOLEAN else 8 * kind.size
                if width > room:
                    self._findings.error(
                        "G0311", field.span, f"{width} bits do not fit {kind.value}"
                    )
                return PrimitiveType(kind)
        if width == 1:
            return PrimitiveType(Primitive.BOOLEAN)
        bits = next(b for b in (8, 16, 32, 64) if width <= b)
        return PrimitiveType(Primitive(f"uint{bits}"))

    # -- typedef, const ------------------------------------------------------------------------

    def _typedef(self, syntax: TypedefSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "typedef", scope)
        used = self._type(syntax.type, scope)
        self._check_complete(used, syntax.type, in_sequences=False)
        for declarator in syntax.declarators:
            symbol = self._names.declare(scope, declarator.name, "typedef")
            full = None if used is None else self._with_dimensions(used, declarator, scope)
            if symbol is None:
                continue
            if full is None:
                symbol.kind = "broken"
                continue
            unit, bounds = self._unit(marks, full), self._range(marks, full)
            self._typedefs[symbol.scoped] = full
            self._of_typedef[symbol.scoped] = (unit, bounds)
            facts = self._facts(declarator.name, syntax.extras, marks)
            self._out.append(Typedef(symbol.scoped, facts, full, unit, bounds))

    def _const(self, syntax: ConstSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "constant", scope)
        used = self._type(syntax.type, scope)
        value = None
        if used is not None:
            target = self._target(used)
            if isinstance(target, PrimitiveType | StringType) or (
                isinstance(target, NamedType)
                and (target.name in self._enums or target.name in self._bitmasks)
            ):
                value = self._typed_value(syntax.value, target, scope)
                self._check_in_range(value, used, syntax.value.span)
            else:
                self._findings.error(
                    "G0310",
                    syntax.type.span,
                    "a constant must be a number, boolean, character, string or enumerator",
                )
        symbol = self._names.declare(scope, syntax.name, "constant")
        if symbol is None or used is None or value is None:
            return
        symbol.type, symbol.value = self._target(used), value
        facts = self._facts(syntax.name, syntax.extras, marks)
        self._out.append(Constant(symbol.scoped, facts, used, value, marks.text("unit")))

    def _check_in_range(self, value: Value | None, used: Type, span: Span) -> None:
        bounds = self._from_typedef(used)[1]
        if bounds is None or isinstance(value, bool) or not isinstance(value, int | float):
            return
        low, high = bounds.minimum, bounds.maximum
        if (low is not None and not value >= low) or (high is not None and not value <= high):
            allowed = (
                f"{'' if low is None else f'from {low}'} {'' if high is None else f'to {high}'}"
            )
            name = used.name if isinstance(used, NamedType) else ""
            self._findings.error(
                "G0301",
                span,
                f"{value} is outside the range of '{name}': {allowed.strip()}",
                "write a value within the range, or give the constant a type without a range",
            )


def _may_discriminate(used: Type, enums: dict[str, EnumDeclaration]) -> bool:
    if isinstance(used, PrimitiveType):
        return not used.kind.is_floating
    return isinstance(used, NamedType) and used.name in enums
