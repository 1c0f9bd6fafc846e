"""Parses interfaces: operations, attributes, and the declarations inside an interface."""

from __future__ import annotations

from abc import abstractmethod

from gidl.syntax.lexer import Token
from gidl.syntax.struct_parser import StructParser
from gidl.syntax.token_reader import Skip
from gidl.syntax.tree import (
    AttributeSyntax,
    ConstSyntax,
    DeclarationSyntax,
    Extras,
    ForwardSyntax,
    InterfaceSyntax,
    Name,
    OperationSyntax,
    ParameterSyntax,
    RefusedSyntax,
    RepositorySyntax,
    ScopedName,
)
from gidl.syntax.type_parser import article


class InterfaceParser(StructParser):
    @abstractmethod
    def _type_declaration(self, extras: Extras) -> DeclarationSyntax | None: ...
    @abstractmethod
    def _const(self, extras: Extras) -> ConstSyntax: ...
    @abstractmethod
    def _refused_declaration(self) -> RefusedSyntax: ...
    @abstractmethod
    def _repository(self) -> RepositorySyntax: ...

    # -- interface_dcl -------------------------------------------------------------------------

    def _interface(self, extras: Extras) -> list[DeclarationSyntax]:
        token = self._now
        if self._ahead.text == "valuetype":
            return [self._refused_declaration()]
        refused = token.text in ("abstract", "local")
        if refused:
            self._refuse_kind(token)
        self._advance()
        name = self._identifier("the interface's name")
        if self._is(";"):
            self._advance()
            return [RefusedSyntax(name) if refused else ForwardSyntax("interface", name)]
        bases: list[ScopedName] = []
        if self._accept(":"):
            bases.append(self._scoped_name("a base interface"))
            while self._accept(","):
                bases.append(self._scoped_name("a base interface"))
        self._opened(extras)
        what = f"interface '{name.text}'"
        opened = self._expect("{", f"to open {what}")
        body: list[DeclarationSyntax] = []
        while not self._is("}") and self._now.kind != "eof":
            before = self._at
            try:
                body.extend(self._export())
            except Skip:
                self._skip_statement()
                if self._at == before and not self._is("}"):
                    self._advance()
        self._close_body(opened, what)
        self._finish(extras, "the interface's '}'")
        return [InterfaceSyntax(name, bases, body, extras)]

    def _refuse_kind(self, token: Token) -> None:
        """Reports an error for `abstract interface` or `local interface`. Forward declarations and
        the full declaration of one interface get only one error."""
        self._advance()
        if token.text == "abstract":
            what = ("G0207", "'abstract interface' is", "leave out 'abstract'")
        else:
            what = ("G0208", "'local interface' is", "write it in C++ or Python by hand")
        self._refuse_once(self._ahead.text, what[0], self._span(token), what[1], what[2])
        if not self._is("interface"):
            raise Skip

    # -- export --------------------------------------------------------------------------------

    def _export(self) -> list[DeclarationSyntax]:
        extras = self._extras()
        token = self._now
        if token.kind == "id":
            match token.text:
                case "readonly" | "attribute":
                    return [self._attribute(extras)]
                case "const":
                    return [self._const(extras)]
                case "exception":
                    return [self._exception(extras)]
                case "typeid" | "typeprefix":
                    return [self._repository()]
                case "native":
                    return [self._refused_declaration()]
                case "interface" | "module":
                    self._findings.error(
                        "G0100",
                        self._span(token),
                        f"{article(token.text)} cannot be declared inside an interface",
                    )
                    raise Skip
            declared = self._type_declaration(extras)
            if declared is not None:
                return [declared]
        if self._is(";"):
            self._findings.error(
                "G0100",
                self._span(token),
                "there is no declaration before this ';'",
                "leave it out",
            )
            self._advance()
            return []
        return [self._operation(extras)]

    # -- op_dcl --------------------------------------------------------------------------------

    def _operation(self, extras: Extras) -> OperationSyntax:
        oneway = self._accept("oneway")
        result = None if self._accept("void") else self._type("an operation, attribute or type")
        name = self._identifier("the operation's name")
        if self._is(";") or self._is(","):
            self._syntax_error(
                "'('", f"after '{name.text}'", "an interface has operations and attributes: write "
                "'attribute' before the type, or '()' after the name"
            )  # fmt: skip
            raise Skip
        self._expect("(", "after the operation's name")
        parameters: list[ParameterSyntax] = []
        while not self._is(")"):
            parameters.append(self._parameter())
            if not self._accept(","):
                break
            self._after(parameters[-1].extras)
            if self._is(")"):
                self._syntax_error("a parameter", "after ','")
                break
        if self._is(")") and parameters:
            self._after(parameters[-1].extras)
        self._expect(")", "after the parameters")
        raises = self._exception_list("raises")
        if self._is("context"):
            self._refuse(
                "G0209", self._span(self._now), "'context' is", "pass the values as parameters"
            )
            raise Skip
        self._finish(extras, "the operation")
        return OperationSyntax(name, oneway, result, parameters, raises, extras)

    def _parameter(self) -> ParameterSyntax:
        extras = self._extras()
        if not (self._is("in") or self._is("out") or self._is("inout")):
            self._syntax_error(
                "'in', 'out' or 'inout'",
                "before a parameter",
                "write 'in' for a value from the caller",
            )
            direction = "in"
        else:
            direction = self._advance().text
        if self._is("@"):
            at = self._span(self._now)
            extras.annotations.extend(self._annotations())
            self._findings.error(
                "G0100", at, f"annotations of a parameter must stand before '{direction}'"
            )
        parameter_type = self._type("the parameter's type")
        name = self._identifier("the parameter's name")
        if self._is("["):
            self._findings.error(
                "G0100",
                self._span(self._now),
                "a parameter cannot be an array directly",
                f"typedef the array and use its name for '{name.text}'",
            )
            while self._accept("["):
                self._expression()
                self._expect("]", "after the array's size")
        return ParameterSyntax(direction, parameter_type, name, extras)

    def _exception_list(self, keyword: str) -> list[ScopedName]:
        names: list[ScopedName] = []
        if self._accept(keyword):
            self._expect("(", f"after '{keyword}'")
            names.append(self._scoped_name("an exception's name"))
            while self._accept(","):
                names.append(self._scoped_name("an exception's name"))
            self._expect(")", "after the exceptions")
        return names

    # -- attr_dcl ------------------------------------------------------------------------------

    def _attribute(self, extras: Extras) -> AttributeSyntax:
        begin = "readonly" if self._accept("readonly") else "attribute"
        self._expect("attribute", "after 'readonly'")
        if self._is("@"):
            at = self._span(self._now)
            self._findings.error(
                "G0100", at, f"annotations of an attribute must stand before '{begin}'"
            )
            self._annotations()
        readonly = begin == "readonly"
        used = self._type("the attribute's type")
        names: list[Name] = [self._identifier("the attribute's name")]
        if self._is("["):
            self._findings.error(
                "G0100",
                self._span(self._now),
                "an attribute cannot be an array directly",
                f"typedef the array and use its name for '{names[0].text}'",
            )
            raise Skip
        while self._accept(","):
            names.append(self._identifier("the attribute's name"))
        if len(names) > 1 and self._now.text in ("raises", "getraises", "setraises"):
            self._syntax_error_at(
                self._now,
                "several attributes cannot share a list of exceptions",
                "declare each attribute separately",
            )
        get_raises: list[ScopedName] = []
        set_raises: list[ScopedName] = []
        if readonly:
            get_raises = self._exception_list("raises")
        else:
            if self._is("raises"):
                self._findings.error(
                    "G0100",
                    self._span(self._now),
                    "a writable attribute must say whether its getter or its setter raises the "
                    "exceptions",
                    "write 'getraises (...)' or 'setraises (...)'",
                )
                get_raises = self._exception_list("raises")
            get_raises = get_raises or self._exception_list("getraises")
            set_raises = self._exception_list("setraises")
        self._finish(extras, "the attribute")
        return AttributeSyntax(names, readonly, used, get_raises, set_raises, extras)
