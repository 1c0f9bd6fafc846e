"""Resolves the parts that all declarations have: names, constants, types and annotations."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator

from gidl.diagnostics.findings import Findings, Note
from gidl.diagnostics.source import Span
from gidl.model import (
    Annotation,
    ArrayType,
    EnumValue,
    Facts,
    Location,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
    Value,
)
from gidl.resolve.constants import (
    Arithmetic,
    Computed,
    compute,
    computed,
    describe_kind,
    refuse_arithmetic,
)
from gidl.resolve.scopes import TYPE_KINDS, Names, Scope, Symbol
from gidl.resolve.vocabulary import Applied, Parameter, Vocabulary, value_hint
from gidl.syntax.tree import (
    AnnotationUse,
    BasicType,
    Declarator,
    Expression,
    Extras,
    InlineType,
    MapOf,
    Name,
    NameUse,
    RefusedType,
    ScopedName,
    SequenceOf,
    StringOf,
    TypeSyntax,
    TypeUse,
)

MAX_BOUND = (1 << 31) - 1
MAX_ARRAY = 1 << 24  # limit for one array, so that fixed sizes fit 32 bits
# The largest double whose nearest float is 0: half of the smallest float. Python would send 0 for a
# smaller number, and C++ compilers refuse such a number as a float literal.
_ROUNDS_TO_ZERO = 2.0**-150

_EXTENSIBILITIES = ("FINAL", "APPENDABLE", "MUTABLE")
BY_VALUE = frozenset(("struct", "union"))
_VALUE_KINDS = frozenset(("constant", "enumerator", "flag"))


class Marks:
    """The annotations of one declaration, by name."""

    def __init__(self, applied: dict[str, Applied], kept: tuple[Annotation, ...]) -> None:
        self._applied = applied
        self.kept = kept

    def __contains__(self, name: str) -> bool:
        return name in self._applied

    def get(self, name: str) -> Applied | None:
        return self._applied.get(name)

    def flag(self, name: str) -> bool:
        """Returns true for @a and @a(TRUE), and false for @a(FALSE) and for a missing
        annotation."""
        applied = self._applied.get(name)
        return applied is not None and applied.arguments.get("value", True) is True

    def text(self, name: str) -> str | None:
        applied = self._applied.get(name)
        return None if applied is None else applied.text()

    def number(self, name: str) -> int | None:
        applied = self._applied.get(name)
        value = None if applied is None else applied.arguments["value"]
        return value if isinstance(value, int) else None

    def written(self) -> list[Applied]:
        return list(self._applied.values())


class ValueResolver(ABC):
    def __init__(self, findings: Findings, names: Names, vocabulary: Vocabulary) -> None:
        self._findings = findings
        self._names = names
        self._vocabulary = vocabulary
        self._typedefs: dict[str, Type] = {}  # scoped name of a typedef -> its type
        self._used_incomplete: set[str] = set()  # incomplete types whose use is already reported

    # -- names ---------------------------------------------------------------------------------

    def _symbol(self, name: ScopedName, scope: Scope, kinds: frozenset[str], what: str,
                code: str) -> Symbol | None:  # fmt: skip
        """Returns the symbol that `name` means. If `name` is unknown or ambiguous, or its kind is
        not in `kinds`, adds a finding and returns None."""
        path = self._names.path(name, scope)
        if not path:
            self._unknown(name, scope, kinds, what, code)
            return None
        symbol = path[-1]
        if symbol.kind == "ambiguous":
            self._ambiguous(name, symbol)
            return None
        if symbol.kind not in kinds:
            self._wrong_kind(name, symbol, scope, kinds, what)
            return None
        self._names.check_spelling(name, path)
        return symbol

    def _unknown(self, name: ScopedName, scope: Scope, kinds: frozenset[str], what: str,
                 code: str) -> None:  # fmt: skip
        if kinds is TYPE_KINDS and name.parts in (("TypeCode",), ("CORBA", "TypeCode")):
            self._findings.error(
                "G0201",
                name.span,
                f"'{name}' is not part of .gidl",
                "use a declared type: types must be known when the interface is compiled",
            )
        elif not self._names.lacks_includes:  # a missing include may declare the name
            hint = self._names.hint(name, scope, kinds)
            self._findings.error(code, name.span, f"unknown {what} '{name}'", hint)

    def _ambiguous(self, name: ScopedName, symbol: Symbol) -> None:
        first, second, *_ = symbol.meanings
        self._findings.error(
            "G0110",
            name.span,
            f"'{name}' is ambiguous: two bases declare it, '{first.scoped}' and '{second.scoped}'",
            f"write the scoped name: '{first.scoped}' or '{second.scoped}'",
            notes=(
                Note("the name is inherited from here", first.span.location),
                Note("the name is also inherited from here", second.span.location),
            ),
        )

    def _wrong_kind(
        self, name: ScopedName, symbol: Symbol, scope: Scope, kinds: frozenset[str], what: str
    ) -> None:
        if symbol.kind == "broken":  # the declaration of the name has a finding already
            return
        hidden = self._names.hidden(name, scope, kinds)
        help_line = ""
        if hidden is not None:
            help_line = (
                f"'{symbol.name}' hides the {what} '{hidden.name}', because names are "
                f"compared without regard to case: write '{'' if '::' in hidden.scoped else '::'}"
                f"{hidden.scoped}'"
            )
        self._findings.error(
            "G0405" if what == "exception" else "G0107",
            name.span,
            f"'{name}' is {_a(symbol.kind)}, not {_a(what)}",
            help_line,
            notes=(Note("declared here", symbol.span.location),),
        )

    # -- constants -----------------------------------------------------------------------------

    def _constant(self, name: ScopedName, scope: Scope) -> Computed | None:
        symbol = self._symbol(name, scope, _VALUE_KINDS, "constant", "G0106")
        if symbol is None or symbol.value is None:
            return None
        if symbol.kind == "constant" and symbol.type == PrimitiveType(Primitive.CHAR):
            return Computed("char", symbol.value)
        return computed(symbol.value)

    def _compute(
        self, expression: Expression, scope: Scope, arithmetic: Arithmetic
    ) -> Computed | None:
        return compute(
            expression, lambda name: self._constant(name, scope), self._findings, arithmetic
        )

    def _typed_value(self, expression: Expression, wanted: Type, scope: Scope) -> Value | None:
        """Returns the value of a constant expression as a value of the type `wanted`. If the
        expression has no such value, adds a finding and returns None."""
        target = self._target(wanted)
        found = self._compute(expression, scope, _arithmetic(target))
        if found is None:
            return None
        return self._fit(found, target, expression.span)

    def _fit(self, found: Computed, wanted: Type, span: Span) -> Value | None:
        target = self._target(wanted)
        value = found.value
        match target:
            case PrimitiveType(Primitive.BOOLEAN):
                fits, what = found.kind == "bool", "a boolean, TRUE or FALSE"
            case PrimitiveType(Primitive.CHAR):
                fits, what = found.kind == "char", "a character"
            case PrimitiveType(kind) if kind.is_floating:
                if refuse_arithmetic(found, span, self._findings):
                    return None
                if found.kind in ("int", "float"):
                    return self._fit_float(found, kind, span)
                fits, what = False, "a floating-point number"
            case PrimitiveType(kind):
                what = "an integer"
                fits = found.kind == "int"
                low, high = kind.integer_limits
                if fits and isinstance(value, int) and not low <= value <= high:
                    self._findings.error(
                        "G0301", span, f"{value} does not fit {kind.value}: {low} to {high}"
                    )
                    return None
            case StringType(bound):
                fits, what = found.kind == "string", "a string"
                if fits and bound is not None and len(str(value).encode()) > bound:
                    self._findings.error("G0301", span, f"this string has more than {bound} bytes")
                    return None
            case NamedType(name):
                fits = isinstance(value, EnumValue) and value.enum == name
                what = f"an enumerator of '{name}'"
            case _:
                fits, what = False, "a value of a type without constants"
        if not fits:
            shown = describe_kind(found.kind)
            if isinstance(value, EnumValue):
                shown = f"an enumerator of '{value.enum}'"
            self._findings.error("G0305", span, f"this is {shown}, where {what} is needed")
            return None
        return value

    def _fit_float(self, found: Computed, kind: Primitive, span: Span) -> float | None:
        assert isinstance(found.value, int | float)
        value = float(found.value)
        if kind is Primitive.FLOAT and math.isfinite(value) and abs(value) > 3.4028235677973366e38:
            self._findings.error("G0301", span, f"{value} does not fit a float")
            return None
        if kind is Primitive.FLOAT and abs(value) <= _ROUNDS_TO_ZERO:
            return math.copysign(0.0, value)
        return value

    def _size(self, expression: Expression, scope: Scope, what: str, most: int) -> int | None:
        """Returns the value of a bound or dimension. If it is not an integer from 1 to `most`, adds
        a finding and returns None."""
        found = self._compute(expression, scope, Arithmetic(32, unsigned=True))
        if found is None:
            return None
        if found.kind != "int" or not isinstance(found.value, int):
            self._findings.error(
                "G0305",
                expression.span,
                f"{what} must be an integer, not {describe_kind(found.kind)}",
            )
            return None
        if not 1 <= found.value <= most:
            self._findings.error(
                "G0306", expression.span, f"{what} must be from 1 to {most}, not {found.value}"
            )
            return None
        return found.value

    # -- types ---------------------------------------------------------------------------------

    def _target(self, used: Type) -> Type:
        while isinstance(used, NamedType) and used.name in self._typedefs:
            used = self._typedefs[used.name]
        return used

    def _type(self, syntax: TypeSyntax, scope: Scope) -> Type | None:
        """Returns the type that `syntax` means. If `syntax` is wrong, an error has been reported,
        and the result is None."""
        match syntax:
            case BasicType(name, _):
                return PrimitiveType(Primitive(name))
            case RefusedType():
                return None
            case InlineType():
                return self._declared_inline(syntax, scope)
            case TypeUse(name, _):
                return self._named(name, scope)
            case StringOf(bound, _):
                if bound is None:
                    return StringType()
                size = self._size(bound, scope, "the bound of a string", MAX_BOUND)
                return None if size is None else StringType(size)
            case SequenceOf(element, bound, annotations, _):
                marks = self._marks(Extras(list(annotations)), "sequence", scope)
                inner = self._type(element, scope)
                size = None
                if bound is not None:
                    size = self._size(bound, scope, "the bound of a sequence", MAX_BOUND)
                if inner is None or (bound is not None and size is None):
                    return None
                return SequenceType(inner, size, marks.text("unit"))
            case MapOf(key, value, bound, _):
                key_type, value_type = self._whole(key, scope), self._whole(value, scope)
                size = None
                if bound is not None:
                    size = self._size(bound, scope, "the bound of a map", MAX_BOUND)
                if key_type is None or value_type is None or (bound is not None and size is None):
                    return None
                return MapType(key_type, value_type, size)

    def _whole(self, syntax: TypeSyntax, scope: Scope) -> Type | None:
        """Resolves a type that must be complete, including the elements of its sequences."""
        used = self._type(syntax, scope)
        self._check_complete(used, syntax, in_sequences=True)
        return used

    def _check_complete(self, used: Type | None, syntax: TypeSyntax, *, in_sequences: bool) -> None:
        incomplete = self._incomplete(used, in_sequences)
        if incomplete is None:
            return
        innermost = syntax
        while isinstance(innermost, SequenceOf):
            innermost = innermost.element
        self._findings.error(
            "G0111",
            innermost.span,
            f"{incomplete.kind} '{incomplete.name}' has only a forward declaration before this use",
            f"move the declaration of the {incomplete.kind} before this use; only a sequence "
            "may use a type before its declaration",
            notes=(Note("declared forward here", incomplete.span.location),),
        )
        self._used_incomplete.add(incomplete.scoped)

    def _incomplete(
        self, used: Type | None, in_sequences: bool, reported: bool = False
    ) -> Symbol | None:
        """Returns the struct or union inside the type `used` that has only a forward declaration so
        far. `reported` tells that `used` comes from a typedef, whose declaration already has a
        finding about this struct or union."""
        match used:
            case NamedType(name) if name in self._typedefs:
                return self._incomplete(self._typedefs[name], in_sequences, True)
            case NamedType(name) if not reported:
                symbol = self._names.declared(name)
                if symbol is None or symbol.kind not in BY_VALUE:
                    return None
                return None if self._names.is_complete(symbol) else symbol
            case ArrayType(element=element):
                return self._incomplete(element, in_sequences, reported)
            case SequenceType(element=element) if in_sequences:
                return self._incomplete(element, in_sequences)
            case _:
                return None

    @abstractmethod
    def _declared_inline(self, syntax: InlineType, scope: Scope) -> NamedType | None: ...

    def _named(self, name: ScopedName, scope: Scope) -> NamedType | None:
        symbol = self._symbol(name, scope, TYPE_KINDS, "type", "G0102")
        if symbol is None:
            return None
        if symbol.kind == "exception":
            self._findings.error(
                "G0108",
                name.span,
                f"'{name}' is an exception: it can be raised, but cannot be the type of a value",
                "declare a struct with the same members",
                notes=(Note("declared here", symbol.span.location),),
            )
            return None
        return NamedType(symbol.scoped)

    def _with_dimensions(self, used: Type, declarator: Declarator, scope: Scope) -> Type | None:
        if not declarator.dimensions:
            return used
        sizes: list[int] = []
        for dimension in declarator.dimensions:
            size = self._size(dimension, scope, "the size of an array", MAX_ARRAY)
            if size is None:
                return None
            sizes.append(size)
        if math.prod(sizes) > MAX_ARRAY:
            self._findings.error(
                "G0306",
                declarator.name.span,
                f"an array has at most {MAX_ARRAY} elements, but this array has {math.prod(sizes)}",
                "use a sequence",
            )
            return None
        return ArrayType(used, tuple(sizes))

    # -- annotations ---------------------------------------------------------------------------

    def _marks(self, extras: Extras, place: str, scope: Scope) -> Marks:
        """Checks the annotations of one declaration and computes their arguments. An annotation
        that is repeated or in the wrong place gets only one finding, even if it is written three
        times."""
        applied: dict[str, Applied] = {}
        reported: set[str] = set()
        kept: list[Annotation] = []
        for use in map(_plain, extras.annotations):
            found = self._apply(use, scope)
            if found is None:
                continue
            one, is_ours = found
            if one.name in reported:
                continue
            if not self._vocabulary.check_repeated(one, applied.get(one.name)):
                reported.add(one.name)
                continue
            if not is_ours:
                arguments = tuple(one.arguments.items())
                kept.append(Annotation(one.name, arguments, one.span.location))
            elif self._vocabulary.check_place(one, place):
                applied[one.name] = one
            else:
                reported.add(one.name)
        return Marks(applied, tuple(kept))

    def _apply(self, use: AnnotationUse, scope: Scope) -> tuple[Applied, bool] | None:
        scopes = [""] if use.name.absolute else [s.name for s in scope.chain()]
        name = "::".join(use.name.parts)
        declared = self._vocabulary.find(name, scopes)
        if declared is None:
            self._vocabulary.unknown(use)
            return self._apply_unknown(use, name, scope)
        if declared.name != name and not declared.name.endswith(f"::{name}"):
            self._vocabulary.unknown(use)
            return None
        given: list[tuple[str | None, Computed, Span]] = []
        for argument, expression in use.arguments:
            named = None if argument is None else argument.text
            meant = [p for p in declared.parameters if named in (None, p.name)]
            if named is not None and not meant:
                self._vocabulary.report_parameter(named, declared, expression.span)
                return None
            value = self._argument(expression, meant, scope)
            if value is None:
                return None
            given.append((named, value, expression.span))
        bound = self._vocabulary.bind(use, declared, given)
        return None if bound is None else (bound, declared.is_ours)

    def _argument(
        self, expression: Expression, meant: list[Parameter], scope: Scope
    ) -> Computed | None:
        """Computes an argument of an annotation. `meant` are the parameters to which the argument
        may belong."""
        literals = {key: value for parameter in meant for key, value in parameter.literals.items()}

        def look_up(name: ScopedName) -> Computed | None:
            if len(name.parts) == 1 and name.parts[0] in literals:
                return computed(literals[name.parts[0]])
            if len(name.parts) == 1 and self._names.look_up(name, scope) is None:
                hint = value_hint(meant, str(name))
                if hint:
                    self._findings.error("G0503", name.span, f"unknown value '{name}'", hint)
                    return None
            return self._constant(name, scope)

        return compute(expression, look_up, self._findings)

    def _apply_unknown(
        self, use: AnnotationUse, name: str, scope: Scope
    ) -> tuple[Applied, bool] | None:
        """Keeps those arguments of an undeclared annotation that can be computed."""
        arguments: dict[str, Value] = {}
        for argument, expression in use.arguments:
            value = compute(expression, lambda n: None, Findings())
            if value is not None:
                arguments[argument.text if argument else "value"] = value.value
        return Applied(name, arguments, frozenset(arguments), use.span), False

    def _facts(self, name: Name, extras: Extras, marks: Marks) -> Facts:
        return Facts(
            name.span.location,
            extras.doc,
            marks.text("version"),
            marks.text("since"),
            marks.text("deprecated"),
            marks.text("hash_as"),
            marks.kept,
            tuple(_written(marks)),
        )


def _written(marks: Marks) -> Iterator[tuple[str, Location]]:
    """Yields the names of annotations and of their written arguments, for example "qos" and
    "qos.depth", each with its location."""
    for applied in marks.written():
        yield applied.name, applied.span.location
        if len(applied.arguments) > 1:
            yield from ((f"{applied.name}.{a}", applied.span.location) for a in applied.written)


def _plain(use: AnnotationUse) -> AnnotationUse:
    """Replaces `@extensibility(FINAL)` by `@final`. Does the same with APPENDABLE and MUTABLE."""
    if use.name.parts == ("extensibility",) and len(use.arguments) == 1:
        value = use.arguments[0][1]
        if isinstance(value, NameUse) and value.name.parts[-1] in _EXTENSIBILITIES:
            short = value.name.parts[-1].lower()
            return AnnotationUse(ScopedName((short,), False, use.name.span), (), use.span)
    return use


def _arithmetic(wanted: Type) -> Arithmetic:
    """Returns the arithmetic for an integer constant of the type `wanted`: 32 bits if the type has
    at most 32 bits, else 64 bits."""
    if isinstance(wanted, PrimitiveType) and wanted.kind.is_integer:
        return Arithmetic(64 if wanted.kind.size == 8 else 32, wanted.kind.is_unsigned)
    return Arithmetic()


def _a(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeio" else f"a {kind}"
