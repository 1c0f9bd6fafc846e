"""Parses structs, exceptions, unions, enums, bitmasks and bitsets."""

from __future__ import annotations

from abc import abstractmethod

from gidl.diagnostics.source import Span
from gidl.syntax.token_reader import Skip
from gidl.syntax.tree import (
    BasicType,
    BitfieldSyntax,
    BitmaskSyntax,
    BitsetSyntax,
    CaseSyntax,
    ConstructedSyntax,
    DeclarationSyntax,
    EnumSyntax,
    Expression,
    Extras,
    ForwardSyntax,
    MemberSyntax,
    NamedItem,
    RefusedType,
    ScopedName,
    StructSyntax,
    UnionSyntax,
)
from gidl.syntax.type_parser import TypeParser


class StructParser(TypeParser):
    """The methods parse a declaration up to its `}`. `_finish` then parses the `;`, if there is
    one."""

    @abstractmethod
    def _extras(self) -> Extras: ...
    @abstractmethod
    def _opened(self, extras: Extras) -> None: ...
    @abstractmethod
    def _finish(self, extras: Extras, where: str) -> None: ...
    @abstractmethod
    def _after(self, extras: Extras) -> None: ...

    # -- constr_type_dcl -----------------------------------------------------------------------

    def _constructed(self, extras: Extras) -> ConstructedSyntax:
        match self._now.text:
            case "struct":
                return self._struct(extras)
            case "union":
                return self._union(extras)
            case "enum":
                return self._enum(extras)
            case "bitmask":
                return self._bitmask(extras)
            case _:
                return self._bitset(extras)

    def _constructed_declaration(self, extras: Extras) -> DeclarationSyntax:
        """Parses a struct, union, enum, bitmask or bitset with its `;`, or a forward
        declaration."""
        kind = self._now.text
        if kind in ("struct", "union") and self._token_at(2).text == ";":
            self._advance()
            forward = ForwardSyntax(kind, self._identifier(f"the {kind}'s name"))
            self._advance()
            return forward
        declaration = self._constructed(extras)
        self._finish(extras, f"the {kind}'s '}}'")
        return declaration

    # -- struct_dcl, except_dcl ----------------------------------------------------------------

    def _struct(self, extras: Extras) -> StructSyntax:
        self._advance()
        name = self._identifier("the struct's name")
        base = self._scoped_name("the base struct") if self._accept(":") else None
        if base is not None and self._is(","):
            self._findings.error(
                "G0100",
                self._span(self._now),
                "a struct has at most one base",
                "keep one base, and declare a member of the other struct's type",
            )
            while self._accept(","):
                self._scoped_name("a name")
        members = self._members(extras, f"struct '{name.text}'")
        return StructSyntax(name, base, members, extras)

    def _exception(self, extras: Extras) -> StructSyntax:
        self._advance()
        name = self._identifier("the exception's name")
        members = self._members(extras, f"exception '{name.text}'")
        self._finish(extras, "the exception's '}'")
        return StructSyntax(name, None, members, extras, is_exception=True)

    def _members(self, extras: Extras, what: str) -> list[MemberSyntax]:
        self._opened(extras)
        opened = self._expect("{", f"to open {what}")
        members: list[MemberSyntax] = []
        while not self._is("}") and self._now.kind != "eof":
            before = self._at
            try:
                members.append(self._member())
            except Skip:
                self._skip_statement()
                if self._at == before and not self._is("}"):
                    self._advance()
        self._close_body(opened, what)
        return members

    def _member(self) -> MemberSyntax:
        extras = self._extras()
        member_type = self._type_or_declaration("a member's type")
        if isinstance(member_type, RefusedType) and self._now.kind not in ("id", "escaped"):
            raise Skip
        declarators = self._declarators("the member's name")
        self._finish(extras, "the member")
        return MemberSyntax(member_type, declarators, extras)

    # -- union_dcl -----------------------------------------------------------------------------

    def _union(self, extras: Extras) -> UnionSyntax:
        self._advance()
        name = self._identifier("the union's name")
        self._expect("switch", "after the union's name")
        self._expect("(", "before the type of the discriminator")
        self._annotations()
        discriminator = self._type_or_declaration("the type of the discriminator")
        self._expect(")", "after the type of the discriminator")
        self._opened(extras)
        what = f"union '{name.text}'"
        opened = self._expect("{", f"to open {what}")
        cases: list[CaseSyntax] = []
        cases_read = True  # False if a case had a syntax error
        while not self._is("}") and self._now.kind != "eof":
            before = self._at
            try:
                cases.append(self._case())
            except Skip:
                cases_read = False
                self._skip_statement()
                if self._at == before and not self._is("}"):
                    self._advance()
        if not cases and cases_read and self._is("}"):
            self._syntax_error("'case' or 'default'", f"in {what}")
        self._close_body(opened, what)
        return UnionSyntax(name, discriminator, cases, extras)

    def _case(self) -> CaseSyntax:
        labels: list[Expression] = []
        default: Span | None = None
        if not (self._is("case") or self._is("default")):
            self._syntax_error("'case' or 'default'", "in a union")
            raise Skip
        while self._is("case") or self._is("default"):
            token = self._advance()
            if token.text == "case":
                labels.append(self._expression())
            else:
                default = self._span(token)
            self._expect(":", f"after '{token.text}'")
        return CaseSyntax(labels, default, self._member())

    # -- enum_dcl, bitmask_dcl -----------------------------------------------------------------

    def _enum(self, extras: Extras) -> EnumSyntax:
        self._advance()
        name = self._identifier("the enum's name")
        items = self._items(extras, f"enum '{name.text}'", "an enumerator")
        return EnumSyntax(name, items, extras)

    def _bitmask(self, extras: Extras) -> BitmaskSyntax:
        self._advance()
        name = self._identifier("the bitmask's name")
        items = self._items(extras, f"bitmask '{name.text}'", "a flag")
        return BitmaskSyntax(name, items, extras)

    def _items(self, extras: Extras, what: str, item_name: str) -> list[NamedItem]:
        self._opened(extras)
        opened = self._expect("{", f"to open {what}")
        items: list[NamedItem] = []
        while True:
            if self._is("}"):
                if items:
                    self._findings.error(
                        "G0100",
                        self._span(self._previous),
                        f"{item_name} is missing after ','",
                        "leave out the last comma",
                    )
                else:
                    self._syntax_error(item_name)
                break
            inner = self._extras()
            if self._now.kind == "macro":
                self._advance()
                if self._accept(","):
                    continue
                break
            item = NamedItem(self._identifier(item_name), inner)
            items.append(item)
            if self._is("="):
                self._findings.error(
                    "G0100",
                    self._span(self._now),
                    "'=' is not allowed here: write the number as an annotation before the name",
                    f"@value(n) {item.name.text}",
                )
                self._advance()
                self._expression()
            more = self._accept(",")
            if more or self._is("}"):
                self._after(inner)
            if not more:
                break
        self._close_body(opened, what)
        return items

    # -- bitset_dcl ----------------------------------------------------------------------------

    def _bitset(self, extras: Extras) -> BitsetSyntax:
        self._advance()
        name = self._identifier("the bitset's name")
        base: ScopedName | None = self._scoped_name("the base") if self._accept(":") else None
        self._opened(extras)
        what = f"bitset '{name.text}'"
        opened = self._expect("{", f"to open {what}")
        fields: list[BitfieldSyntax] = []
        while not self._is("}") and self._now.kind != "eof":
            before = self._at
            try:
                fields.append(self._bitfield())
            except Skip:
                self._skip_statement()
                if self._at == before and not self._is("}"):
                    self._advance()
        self._close_body(opened, what)
        return BitsetSyntax(name, base, fields, extras)

    def _bitfield(self) -> BitfieldSyntax:
        extras = self._extras()
        start = self._expect("bitfield", "in a bitset")
        self._expect("<", "after 'bitfield'")
        width = self._bound()
        used: BasicType | RefusedType | None = None
        if self._accept(","):
            parsed = self._type("the type of the field")
            used = (
                parsed if isinstance(parsed, BasicType | RefusedType) else RefusedType(parsed.span)
            )
            if not isinstance(parsed, BasicType | RefusedType):
                self._findings.error(
                    "G0311", parsed.span, "a bitfield must be boolean, octet or an integer"
                )
        self._close_angle("the bitfield")
        names = []
        if not self._is(";"):
            names.append(self._identifier("the field's name"))
            while self._accept(","):
                names.append(self._identifier("the field's name"))
        span = self._since(start)
        self._finish(extras, "the bitfield")
        return BitfieldSyntax(width, used, names, extras, span)
