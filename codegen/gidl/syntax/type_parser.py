"""Parses types, declarators and annotations."""

from __future__ import annotations

from abc import abstractmethod

from gidl.syntax.expression_parser import ExpressionParser
from gidl.syntax.lexer import Token
from gidl.syntax.token_reader import Skip
from gidl.syntax.tree import (
    AnnotationUse,
    BasicType,
    Binary,
    ConstructedSyntax,
    Declarator,
    Expression,
    Extras,
    InlineType,
    Literal,
    MapOf,
    Name,
    RefusedType,
    ScopedName,
    SequenceOf,
    StringOf,
    TypeSyntax,
    TypeUse,
)

_SIMPLE_TYPES = {
    "boolean": "boolean", "octet": "octet", "char": "char", "float": "float", "double": "double",
    "short": "int16", "int8": "int8", "int16": "int16", "int32": "int32", "int64": "int64",
    "uint8": "uint8", "uint16": "uint16", "uint32": "uint32", "uint64": "uint64",
}  # fmt: skip

_WIDE_HELP = "use a string, which is UTF-8; with --wide=utf8, wide text is read as UTF-8"
_REFUSED_TYPES = {
    "any": ("G0201", "'any' is", "declare a union of the types that the value may have"),
    "ValueBase": ("G0202", "'ValueBase' is", "use a struct"),
    "fixed": ("G0203", "'fixed' is", "use an int64 in the smallest unit, or a double"),
    "wchar": ("G0206", "'wchar' is", _WIDE_HELP),
    "wstring": ("G0206", "'wstring' is", _WIDE_HELP),
}

_BYTES_OF_A_CHARACTER = 4  # the largest number of bytes in UTF-8
_OBJECT_REF = ("gecos", "ObjectRef")
_CONSTRUCTED = ("struct", "union", "enum", "bitmask", "bitset")


class TypeParser(ExpressionParser):
    """Each method parses one grammar rule; the next token must be the first token of that rule."""

    _uses_object = False  # True: the file uses the type `Object`

    @abstractmethod
    def _constructed(self, extras: Extras) -> ConstructedSyntax: ...

    # -- annotations ---------------------------------------------------------------------------

    def _annotations(self) -> list[AnnotationUse]:
        found = []
        while self._is("@") and not (self._ahead.kind == "id" and self._ahead.text == "annotation"):
            found.append(self._annotation())
        return found

    def _annotation(self) -> AnnotationUse:
        """Parses an annotation. A "::" after a space is not part of the name of the annotation, but
        begins a type, as in `@optional ::m::Pose where`."""
        start = self._advance()
        name_token = self._now
        is_scoped = self._ahead.text == "::" and self._ahead.start == name_token.end
        if name_token.kind == "id" and not is_scoped:
            self._advance()
            name = ScopedName((name_token.text,), False, self._span(name_token))
        else:
            name = self._scoped_name("the name of an annotation after '@'", in_one_piece=True)
        arguments: list[tuple[Name | None, Expression]] = []
        if self._is("("):
            arguments = self._annotation_arguments()
        return AnnotationUse(name, tuple(arguments), self._since(start))

    def _annotation_arguments(self) -> list[tuple[Name | None, Expression]]:
        self._advance()
        outer, self._in_angles = self._in_angles, False
        self._in_annotation = True
        arguments: list[tuple[Name | None, Expression]] = []
        while not self._is(")"):
            name = None
            if self._now.kind in ("id", "escaped") and self._ahead.text == "=":
                token = self._advance()
                name = Name(token.text, self._span(token))
                self._advance()
            arguments.append((name, self._expression()))
            if not self._accept(","):
                break
        self._in_angles, self._in_annotation = outer, False
        self._expect(")", "at the end of the annotation")
        return arguments

    # -- type_spec -----------------------------------------------------------------------------

    def _type_or_declaration(self, what: str = "a type") -> TypeSyntax:
        """Parses a type that may also be declared here, as in `struct T { ... } member;`."""
        token = self._now
        if token.kind != "id" or token.text not in _CONSTRUCTED or not self._declares_here():
            return self._type(what)
        if self._ahead.text == "{":
            self._findings.error(
                "G0100",
                self._span(token),
                f"this {token.text} has no name",
                f"write a name after the keyword: {token.text} Name {{ ... }}",
            )
            self._skip_braces()
            return RefusedType(self._since(token))
        with self._nested():
            return InlineType(self._constructed(Extras()), self._since(token))

    def _declares_here(self) -> bool:
        return self._ahead.text in ("{", "switch") or self._token_at(2).text in ("{", "switch", ":")

    def _type_of_macro(self) -> RefusedType:
        """Reads the use of a macro with parameters as a type if a name follows on the same line. If
        no name follows, the macro stands for a whole declaration, and the method raises Skip."""
        token = self._advance()
        if self._now.kind not in ("id", "escaped") or self._starts_line():
            raise Skip
        return RefusedType(self._span(token))

    def _type(self, what: str = "a type") -> TypeSyntax:
        with self._nested():
            token = self._now
            if token.kind == "macro":
                return self._type_of_macro()
            if token.kind == "id":
                if token.text in _SIMPLE_TYPES:
                    self._advance()
                    return BasicType(_SIMPLE_TYPES[token.text], self._span(token))
                if self._wide and token.text in ("wchar", "wstring"):
                    return self._wide_type()
                if token.text in _REFUSED_TYPES:
                    return self._refused_type()
                match token.text:
                    case "Object":
                        self._advance()
                        self._uses_object = True
                        name = ScopedName(_OBJECT_REF, True, self._span(token))
                        return TypeUse(name, name.span)
                    case "long" | "unsigned":
                        return self._integer_type()
                    case "string":
                        return self._string_type()
                    case "sequence":
                        return self._sequence_type()
                    case "map":
                        return self._map_type()
                    case "struct" | "union" | "enum" | "bitmask" | "bitset":
                        return self._misplaced_declaration()
            if token.kind in ("id", "escaped") or self._is("::"):
                name = self._scoped_name(what)
                return TypeUse(name, name.span)
            self._syntax_error(what)
            raise Skip

    def _integer_type(self) -> TypeSyntax:
        """Parses `long`, `long long`, `unsigned short` and similar types; refuses `long double`."""
        start = self._now
        unsigned = self._accept("unsigned")
        if self._accept("short"):
            bits = 16
        elif self._accept("long"):
            bits = 32
            if self._accept("long"):
                bits = 64
            elif self._is("double") and not unsigned:
                self._advance()
                span = self._since(start)
                self._refuse("G0204", span, "'long double' is", "use a double")
                return RefusedType(span)
        else:
            self._syntax_error("'short' or 'long'", "after 'unsigned'")
            raise Skip
        return BasicType(f"{'u' if unsigned else ''}int{bits}", self._since(start))

    def _string_type(self) -> StringOf:
        start = self._advance()
        bound = None
        if self._accept("<"):
            bound = self._bound()
            self._close_angle("the string's bound")
        return StringOf(bound, self._since(start))

    def _wide_type(self) -> StringOf:
        """Parses a wide type as a string type. `wstring` has no bound, `wchar` has room for one
        character, and `wstring<N>` has room for N characters of up to 4 bytes."""
        token = self._advance()
        room = Literal(_BYTES_OF_A_CHARACTER, "int", self._span(token))
        if token.text == "wchar":
            return StringOf(room, self._span(token))
        bound = None
        if self._accept("<"):
            written = self._bound()
            bound = Binary("*", written, room, written.span)
            self._close_angle("the string's bound")
        return StringOf(bound, self._since(token))

    def _sequence_type(self) -> SequenceOf:
        start = self._advance()
        self._expect("<", "after 'sequence'")
        annotations = tuple(self._annotations())
        element = self._type("the type of the elements")
        bound = self._bound() if self._accept(",") else None
        self._close_angle("the sequence")
        return SequenceOf(element, bound, annotations, self._since(start))

    def _map_type(self) -> MapOf:
        start = self._advance()
        self._expect("<", "after 'map'")
        key = self._type("the type of the keys")
        self._expect(",", "after the map's key type")
        value = self._type("the type of the values")
        bound = self._bound() if self._accept(",") else None
        self._close_angle("the map")
        return MapOf(key, value, bound, self._since(start))

    def _value_of(self, used: TypeSyntax) -> Expression:
        """Parses the value of a constant. If the type of the constant is unsupported, the value is
        skipped."""
        if not isinstance(used, RefusedType):
            return self._expression()
        start = self._now
        while not self._is(";") and not self._is("}") and self._now.kind != "eof":
            self._advance()
        return Literal(0, "int", self._span(start))

    def _bound(self) -> Expression:
        outer, self._in_angles = self._in_angles, True
        try:
            return self._expression()
        finally:
            self._in_angles = outer

    def _close_angle(self, what: str) -> None:
        token = self._now
        if token.kind == "op" and token.text == ">>":
            rest = Token("op", ">", min(token.start + 1, token.end), token.end)
            self._tokens[self._at] = rest
            return
        self._expect(">", f"after {what}")

    def _refused_type(self) -> RefusedType:
        token = self._advance()
        code, what, instead = _REFUSED_TYPES[token.text]
        if self._accept("<"):
            while self._now.kind in ("int", "id", "escaped") or self._is(",") or self._is("::"):
                self._advance()
            self._close_angle(token.text)
        self._refuse(code, self._span(token), what, instead)
        self._wide_refused |= code == "G0206"
        return RefusedType(self._since(token))

    def _misplaced_declaration(self) -> TypeSyntax:
        """Reports `struct S` used as a type (C style), or a type that is declared where it must not
        be."""
        declares = self._declares_here()
        token = self._advance()
        if self._now.kind in ("id", "escaped") and not declares:
            name = self._scoped_name("a type")
            self._findings.error(
                "G0100",
                self._span(token),
                f"'{token.text}' must not be written before the name of an existing type",
                f"write '{name}'",
            )
            return TypeUse(name, name.span)
        self._refuse(
            "G0213",
            self._span(token),
            f"declaring {article(token.text)} here is",
            f"declare the {token.text} before, and use its name here",
        )
        while self._now.text not in ("{", ";", "}") and self._now.kind != "eof":
            self._advance()
        if self._is("{"):
            self._skip_braces()
        return RefusedType(self._since(token))

    def _skip_braces(self) -> None:
        depth = 0
        while self._now.kind != "eof":
            token = self._advance()
            if token.kind == "op" and token.text == "{":
                depth += 1
            elif token.kind == "op" and token.text == "}":
                depth -= 1
                if depth == 0:
                    return

    # -- declarators ---------------------------------------------------------------------------

    def _declarators(self, what: str) -> list[Declarator]:
        found = [self._declarator(what)]
        while self._accept(","):
            found.append(self._declarator(what))
        return found

    def _declarator(self, what: str) -> Declarator:
        name = self._identifier(what)
        dimensions = []
        while self._accept("["):
            dimensions.append(self._expression())
            self._expect("]", "after the array's size")
        return Declarator(name, tuple(dimensions))


def article(word: str) -> str:
    return f"an {word}" if word[0] in "aeio" else f"a {word}"
