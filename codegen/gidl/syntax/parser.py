"""Builds the syntax tree from tokens, by recursive descent with one method for each grammar rule.

After an error, parsing continues at the next declaration, so that one run reports all errors.
"""

from __future__ import annotations

from collections.abc import Callable

from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Source
from gidl.syntax.conditions import Macros
from gidl.syntax.docs_text import DocReader, joined
from gidl.syntax.interface_parser import InterfaceParser
from gidl.syntax.lexer import Token, lex
from gidl.syntax.preprocess import Preprocessed, preprocess
from gidl.syntax.token_reader import GiveUp, Skip, keyword_hint
from gidl.syntax.tree import (
    AnnotationParameterSyntax,
    AnnotationSyntax,
    ConstSyntax,
    DeclarationSyntax,
    Extras,
    FileSyntax,
    ImportSyntax,
    Include,
    ModuleSyntax,
    Name,
    RefusedSyntax,
    RepositorySyntax,
    ScopedName,
    TypedefSyntax,
)

_REFUSED = {
    "valuetype": ("G0202", "'valuetype' is", "use a struct"),
    "native": ("G0205", "'native' is", "use a struct with @maps_to for a hand-written type"),
    "component": ("G0210", "components are", "use an interface"),
    "home": ("G0210", "components are", "use an interface"),
    "eventtype": ("G0210", "components are", "use an @event operation"),
    "connector": ("G0210", "components are", "use an interface"),
    "alias": ("G0215", "template modules are", "declare the type that the template expands to"),
    "porttype": ("G0210", "components are", "use an interface"),
    "custom": ("G0202", "'valuetype' is", "use a struct"),
}

_STARTS = (
    "module", "interface", "struct", "union", "enum", "exception", "typedef", "const", "bitmask",
    "bitset", "import", "typeid", "typeprefix", "abstract", "local",
)  # fmt: skip


def parse(
    source: Source,
    findings: Findings,
    macros: Macros,
    on_include: Callable[[Include], None],
    *,
    wide: bool = False,
) -> FileSyntax:
    """Parses one file. Never raises: syntax errors are reported, and wrong declarations are left
    out of the tree. With `wide`, wide strings and characters are read as strings."""
    of_tokens = Findings()
    lexed = lex(source, of_tokens)
    done = preprocess(lexed, findings, macros, on_include)
    findings.take(of_tokens, [_lines(source, *stretch) for stretch in done.skipped])
    parser = Parser(source, done, DocReader(lexed, done.skipped), findings)
    parser._wide = wide
    tree = parser.file()
    tree.uses_object = parser._uses_object
    tree.includes = done.includes
    if done.first_directive is not None:
        tree.doc = DocReader(lexed, done.skipped).head(done.first_directive)
    return tree


def _lines(source: Source, start: int, end: int) -> range:
    """Returns the numbers of the lines between two preprocessor lines, whose offsets are `start`
    and `end`."""
    return range(source.location(start).line + 1, source.location(end).line)


class Parser(InterfaceParser):
    def __init__(
        self, source: Source, done: Preprocessed, docs: DocReader, findings: Findings
    ) -> None:
        super().__init__(source, done.tokens, findings)
        self._docs = docs
        self._trailing = dict(done.trailing)

    # -- specification -------------------------------------------------------------------------

    def file(self) -> FileSyntax:
        tree = FileSyntax()
        try:
            while self._now.kind != "eof":
                if self._is("}"):
                    self._findings.error(
                        "G0100", self._span(self._now), "this '}' has no matching '{'"
                    )
                    self._advance()
                    self._accept(";")
                    continue
                self._one_definition(tree.body)
        except GiveUp:
            return tree
        for tokens in self._trailing.values():
            self._findings.error(
                "G0502",
                self._span(tokens[0]),
                "this //@ comment annotates nothing",
                "put the comment after the ';' or ',' of the annotated declaration, or alone "
                "on the line "
                "before",
            )
        return tree

    def _one_definition(self, into: list[DeclarationSyntax]) -> None:
        before = self._at
        try:
            into.extend(self._definition())
        except Skip:
            self._skip_statement()
        if self._at == before and not self._is("}"):
            self._advance()

    def _body(self, what: str) -> list[DeclarationSyntax]:
        """Parses the `{ definition ... }` of a module."""
        opened = self._expect("{", f"to open {what}")
        body: list[DeclarationSyntax] = []
        with self._nested():
            while not self._is("}") and self._now.kind != "eof":
                self._one_definition(body)
        self._close_body(opened, what)
        return body

    # -- definition ----------------------------------------------------------------------------

    def _definition(self) -> list[DeclarationSyntax]:
        extras = self._extras()
        token = self._now
        if self._is("@"):
            return [self._annotation_declaration(extras)]
        if token.kind == "id":
            match token.text:
                case "module":
                    return [self._module(extras)]
                case "const":
                    return [self._const(extras)]
                case "interface" | "abstract" | "local":
                    return self._interface(extras)
                case "exception":
                    return [self._exception(extras)]
                case "import":
                    return [self._import()]
                case "typeid" | "typeprefix":
                    return [self._repository()]
            if token.text in _REFUSED and self._ahead.kind in ("id", "escaped"):
                return [self._refused_declaration()]
            found = self._type_declaration(extras)
            if found is not None:
                return [found]
        if token.kind == "macro":
            self._advance()
            if not self._accept(";") and not self._starts_line():
                raise Skip
            return []
        if self._is(";"):
            self._findings.error(
                "G0100",
                self._span(token),
                "there is no declaration before this ';'",
                "leave it out",
            )
            self._advance()
            return []
        self._syntax_error("a declaration", "", _start_hint(token.text))
        raise Skip

    def _refused_declaration(self) -> RefusedSyntax:
        """Skips an unsupported declaration, and reports it once for each name. The name stays
        known, so that uses of the name are not reported."""
        keyword = self._advance()
        if self._is("valuetype"):  # after `custom` or `abstract`
            keyword = self._advance()
        code, what, instead = _REFUSED[keyword.text]
        name = Name(self._now.text, self._span(self._now))
        self._refuse_once(name.text, code, self._span(keyword), what, instead)
        while not self._is("{") and not self._is(";") and self._now.kind != "eof":
            self._advance()
        if self._is("{"):
            self._skip_braces()
        self._accept(";")
        return RefusedSyntax(name)

    def _type_declaration(self, extras: Extras) -> DeclarationSyntax | None:
        """Parses the grammar rule type_dcl, which modules and interfaces may contain. Returns None
        if the next token does not begin one."""
        match self._now.text if self._now.kind == "id" else "":
            case "struct" | "union" | "enum" | "bitmask" | "bitset":
                return self._constructed_declaration(extras)
            case "typedef":
                return self._typedef(extras)
            case _:
                return None

    def _module(self, extras: Extras) -> ModuleSyntax | RefusedSyntax:
        self._advance()
        name = self._identifier("the module's name")
        if self._is("<"):
            what = _REFUSED["alias"]
            self._refuse(what[0], self._span(self._now), what[1], what[2])
            self._skip_braces()
            self._accept(";")
            return RefusedSyntax(name)
        self._opened(extras)
        if self._is("{") and self._ahead.text == "}" and self._ahead.kind == "op":
            self._syntax_error_at(
                self._ahead, f"module '{name.text}' is empty", "a module must contain a declaration"
            )
        body = self._body(f"module '{name.text}'")
        self._finish(extras, "the module's '}'")
        return ModuleSyntax(name, body, extras)

    def _const(self, extras: Extras) -> ConstSyntax:
        self._advance()
        const_type = self._type("the constant's type")
        name = self._identifier("the constant's name")
        self._expect("=", "after the constant's name")
        value = self._value_of(const_type)
        self._finish(extras, "the constant")
        return ConstSyntax(const_type, name, value, extras)

    def _typedef(self, extras: Extras) -> TypedefSyntax:
        self._advance()
        aliased = self._type_or_declaration()
        declarators = self._declarators("the new type's name")
        self._finish(extras, "the typedef")
        return TypedefSyntax(aliased, declarators, extras)

    def _import(self) -> ImportSyntax:
        self._advance()
        if self._now.kind == "string":
            token = self._now
            literal = self._literal()
            text = str(literal.value)
            if not text.startswith("IDL:"):
                self._findings.error(
                    "G0100",
                    self._span(token),
                    "an imported string must be a repository identifier such as "
                    '"IDL:robcl/Frame:1.0"',
                    "to include another file, write #include",
                )
                raise Skip
            parts = tuple(text.removeprefix("IDL:").rpartition(":")[0].split("/"))
            name = ScopedName(parts, True, literal.span)
        else:
            name = self._scoped_name("the name to import")
        self._expect_semicolon("the import")
        return ImportSyntax(name)

    def _repository(self) -> RepositorySyntax:
        kind = self._advance().text
        name = self._scoped_name("a name")
        if self._now.kind != "string":
            self._syntax_error("a string")
            raise Skip
        text = str(self._literal().value)
        self._expect_semicolon(kind)
        return RepositorySyntax(kind, name, text)

    # -- annotation_dcl ------------------------------------------------------------------------

    def _annotation_declaration(self, extras: Extras) -> AnnotationSyntax:
        self._advance()
        self._advance()
        token = self._now
        if token.kind not in ("id", "escaped"):
            self._syntax_error("the annotation's name")
            raise Skip
        self._advance()  # keywords may name annotations, such as @default
        name = Name(token.text, self._span(token), token.kind == "escaped")
        opened = self._expect("{", "to open the annotation's parameters")
        parameters: list[AnnotationParameterSyntax] = []
        body: list[DeclarationSyntax] = []
        with self._nested():
            while not self._is("}") and self._now.kind != "eof":
                try:
                    self._annotation_member(parameters, body)
                except Skip:
                    self._skip_statement()
        self._close_body(opened, f"annotation '{name.text}'")
        self._finish(extras, "the annotation's '}'")
        return AnnotationSyntax(name, parameters, body, extras)

    def _annotation_member(
        self, parameters: list[AnnotationParameterSyntax], body: list[DeclarationSyntax]
    ) -> None:
        extras = self._extras()
        match self._now.text:
            case "enum":
                body.append(self._constructed_declaration(extras))
            case "const":
                body.append(self._const(extras))
            case "typedef":
                body.append(self._typedef(extras))
            case _:
                parameter_type = None if self._accept("any") else self._type("the parameter's type")
                name = self._identifier("the parameter's name")
                default = self._expression() if self._accept("default") else None
                self._finish(extras, "the parameter")
                parameters.append(AnnotationParameterSyntax(name, parameter_type, default))

    # -- documentation and annotations around declarations --------------------------------------

    def _extras(self) -> Extras:
        """Parses documentation and annotations before a declaration."""
        first = self._now
        doc = self._docs.before(self._previous.end, first.start)
        annotations = self._annotations()
        if annotations and not doc:
            doc = self._docs.before(first.end, self._now.start)
        return Extras(annotations, doc)

    def _opened(self, extras: Extras) -> None:
        """If the next token is `{`, adds the annotations in `//@` comments after this brace to the
        declaration whose body the brace opens."""
        if self._is("{"):
            self._take_trailing(extras, self._now)

    def _finish(self, extras: Extras, where: str) -> None:
        """Parses the closing `;`, then the documentation and `//@` comments on the same line."""
        self._expect_semicolon(where)
        self._after(extras)

    def _after(self, extras: Extras) -> None:
        previous = self._previous
        self._take_trailing(extras, previous)
        extras.doc = joined(extras.doc, self._docs.after(previous.end))

    def _take_trailing(self, extras: Extras, token: Token) -> None:
        tokens = self._trailing.pop(token.start, None)
        if not tokens:
            return
        reader = Parser.__new__(Parser)
        end = tokens[-1].end
        InterfaceParser.__init__(
            reader, self._source, [*tokens, Token("eof", "", end, end)], self._findings
        )
        reader._wide = self._wide
        try:
            extras.annotations.extend(reader._annotations())
            if reader._now.kind != "eof":
                reader._syntax_error("an annotation", "in a //@ comment")
        except (Skip, GiveUp):
            return


def _start_hint(word: str) -> str:
    hint = keyword_hint(word)
    return hint if any(f"'{start}'" in hint for start in _STARTS) else ""
