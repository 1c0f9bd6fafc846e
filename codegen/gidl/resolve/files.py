"""Builds the model from syntax trees: looks up names, computes constants, and interprets
annotations.

Included files must come before the files that include them. Declarations are resolved in the order
written, because IDL requires that a name is declared before its use. Wrong declarations are
reported and left out of the model.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from gidl.diagnostics.findings import Findings, Note
from gidl.files.loader import VOCABULARY, LoadedFile
from gidl.model import (
    Annotation,
    AnnotationDeclaration,
    AnnotationParameter,
    AnyDeclaration,
    Declaration,
    EnumDeclaration,
    EnumValue,
    Facts,
    File,
    Interface,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    Struct,
    Union,
    Value,
)
from gidl.resolve.interfaces import InterfaceResolver
from gidl.resolve.scopes import Names, Scope, Symbol
from gidl.resolve.values import BY_VALUE
from gidl.resolve.vocabulary import Declared, Parameter, Vocabulary
from gidl.syntax.annotation_places import PLACES
from gidl.syntax.tree import (
    AnnotationSyntax,
    AttributeSyntax,
    DeclarationSyntax,
    FileSyntax,
    ForwardSyntax,
    ImportSyntax,
    InlineType,
    InterfaceSyntax,
    ModuleSyntax,
    RefusedSyntax,
    RepositorySyntax,
    ScopedName,
    StructSyntax,
    TypedefSyntax,
    UnionSyntax,
)

_COMPLETE_HERE = "write the full declaration in this file or in a file that this file includes"


def resolve(files: Iterable[LoadedFile], vocabulary: FileSyntax, findings: Findings) -> Model:
    """Returns the model of `files`, each of which must come after the files that it includes."""
    resolver = Resolver(findings)
    resolver.read_vocabulary(vocabulary)
    return resolver.model(files)


class Resolver(InterfaceResolver):
    def __init__(self, findings: Findings) -> None:
        super().__init__(findings, Names(findings), Vocabulary(findings))
        self._modules: list[Declaration] = []
        self._repository: dict[str, list[Annotation]] = {}
        self._reading_vocabulary = False

    def read_vocabulary(self, tree: FileSyntax) -> None:
        self._reading_vocabulary = True
        self._names.visible = {VOCABULARY}
        for syntax in tree.body:
            if isinstance(syntax, AnnotationSyntax):
                self._annotation(syntax, self._names.top)
        self._reading_vocabulary = False
        self._out = []

    def model(self, files: Iterable[LoadedFile]) -> Model:
        made: list[File] = []
        places: dict[str, int] = {}
        visible: dict[str, set[str]] = {}
        for loaded in files:
            self._out = []
            self._modules = []
            self._names.visible = set(loaded.visible)
            self._names.lacks_includes = loaded.lacks_includes
            self._names.cut = loaded.cut
            self._names.declared_here = dict(_declared_names(loaded.tree.body))
            if loaded.source.path != VOCABULARY:
                for syntax in loaded.tree.body:
                    self._declaration(syntax, self._names.top)
            visible[loaded.source.path] = self._names.visible
            places[loaded.source.path] = len(made)
            made.append(
                File(
                    loaded.source.path,
                    tuple(loaded.includes),
                    tuple(self._out),
                    loaded.asked_for,
                    loaded.tree.doc,
                    tuple(self._modules),
                )
            )
        self._report_incomplete(made, places)
        self._report_completed_elsewhere(visible)
        if self._repository:
            made = [_with_repository(file, self._repository) for file in made]
        return Model(tuple(made))

    def _declaration(self, syntax: DeclarationSyntax, scope: Scope) -> None:
        match syntax:
            case ModuleSyntax():
                self._module(syntax, scope)
            case InterfaceSyntax():
                self._interface(syntax, scope)
            case AnnotationSyntax():
                self._annotation(syntax, scope)
            case ImportSyntax():
                self._import(syntax, scope)
            case RepositorySyntax():
                self._repository_name(syntax, scope)
            case RefusedSyntax():
                self._names.poison(scope, syntax.name)
            case _:
                self._type_declaration(syntax, scope)

    def _module(self, syntax: ModuleSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "module", scope)
        symbol = self._names.declare(scope, syntax.name, "module")
        if symbol is None:
            inside = Scope(scope.qualified(syntax.name.text), "module", scope)
        else:
            if symbol.scope is None:
                symbol.scope = Scope(symbol.scoped, "module", scope)
            inside = symbol.scope
        facts = self._facts(syntax.name, syntax.extras, marks)
        self._modules.append(Declaration(inside.name, facts))
        for item in syntax.body:
            self._declaration(item, inside)

    # -- annotations declared with @annotation ---------------------------------------------------

    def _annotation(self, syntax: AnnotationSyntax, scope: Scope) -> None:
        own = "@" + syntax.name.text
        inside = Scope(scope.qualified(own), "annotation", scope)
        before = len(self._out)
        for item in syntax.body:
            self._declaration(item, inside)
        enums = [d for d in self._out[before:] if isinstance(d, EnumDeclaration)]
        del self._out[before:]
        parameters = []
        for parameter in syntax.parameters:
            literals: dict[str, Value] = {}
            used = None if parameter.type is None else self._type(parameter.type, inside)
            if parameter.type is not None and used is None:
                continue
            used = None if used is None else self._target(used)
            if isinstance(used, NamedType):
                for enum in enums:
                    if enum.name == used.name:
                        literals = {
                            e.name: EnumValue(enum.name, e.name, e.number) for e in enum.enumerators
                        }
            default = None
            if parameter.default is not None:
                meant = [Parameter(parameter.name.text, used, None, literals)]
                found = self._argument(parameter.default, meant, inside)
                if found is not None:
                    default = (
                        found.value
                        if used is None
                        else self._fit(found, used, parameter.default.span)
                    )
            self._names.declare(inside, parameter.name, "parameter")
            parameters.append(Parameter(parameter.name.text, used, default, literals))
        name = scope.qualified(syntax.name.text)
        is_ours = self._reading_vocabulary
        self._vocabulary.add(Declared(name, tuple(parameters), syntax.name.span, is_ours))
        if not is_ours and name not in PLACES:
            marks = self._marks(syntax.extras, "annotation", scope)
            facts = self._facts(syntax.name, syntax.extras, marks)
            shown = tuple(AnnotationParameter(p.name, p.type, p.default) for p in parameters)
            self._out.append(AnnotationDeclaration(inside.name, facts, shown))

    # -- import, typeid, typeprefix --------------------------------------------------------------

    def _import(self, syntax: ImportSyntax, scope: Scope) -> None:
        path = self._anywhere(syntax.name, scope)
        if not path:
            self._findings.error(
                "G0106",
                syntax.name.span,
                f"nothing called '{syntax.name}' is declared in the files of this run",
                "#include the file that declares it",
            )
            return
        self._names.check_spelling(syntax.name, path)
        symbol = path[-1]
        if symbol.kind == "module":
            self._names.visible.update(_files_of(symbol))
        else:
            self._names.visible.add(symbol.file)

    def _anywhere(self, name: ScopedName, scope: Scope) -> list[Symbol]:
        """Returns the symbols of all parts of a name. Unlike a normal look-up, also finds
        declarations in files that are not included. The list is empty if the name is unknown."""
        visible = self._names.visible
        self._names.visible = visible | _files_of_scope(self._names.top)
        try:
            return self._names.path(name, Scope(scope.name, scope.kind, scope))
        finally:
            self._names.visible = visible

    def _repository_name(self, syntax: RepositorySyntax, scope: Scope) -> None:
        path = self._names.path(syntax.name, Scope(scope.name, scope.kind, scope))
        if not path:
            self._findings.error(
                "G0106",
                syntax.name.span,
                f"unknown name '{syntax.name}'",
                "declare the name before its use",
            )
            return
        self._names.check_spelling(syntax.name, path)
        symbol = path[-1]
        kept = Annotation(syntax.kind, (("value", syntax.text),), syntax.name.span.location)
        self._repository.setdefault(symbol.scoped, []).append(kept)

    # -- forward declarations --------------------------------------------------------------------

    def _report_incomplete(self, files: list[File], places: dict[str, int]) -> None:
        """Reports types that are declared forward but never completed, and adds them to the model
        as empty types."""
        for symbol in list(self._names.incomplete()):
            if symbol.scoped not in self._used_incomplete:
                self._findings.error(
                    "G0113",
                    symbol.span,
                    f"{symbol.kind} '{symbol.name}' is declared forward but never completed",
                    _COMPLETE_HERE,
                )
            facts = Facts(symbol.span.location)
            empty: AnyDeclaration
            if symbol.kind == "struct":
                empty = Struct(symbol.scoped, facts, ())
            elif symbol.kind == "union":
                empty = Union(symbol.scoped, facts, PrimitiveType(Primitive.INT32), ())
            else:
                empty = Interface(symbol.scoped, facts, (), (), ())
            file = files[places[symbol.file]]
            completed = replace(file, declarations=(*file.declarations, empty))
            files[places[symbol.file]] = completed

    def _report_completed_elsewhere(self, visible: Mapping[str, set[str]]) -> None:
        """Reports structs and unions that a file declares forward, but that are completed in a file
        that it does not include. Code that is generated from the first file would lack the type.
        `visible` has, for each file, the paths of the file itself and of its includes."""
        for symbol, span in self._names.forwards:
            lacks = symbol.completed_in and symbol.completed_in not in visible[span.source.path]
            if lacks and symbol.kind in BY_VALUE and symbol.scoped not in self._used_incomplete:
                self._findings.error(
                    "G0113",
                    span,
                    f"{symbol.kind} '{symbol.name}' is declared forward here, but completed in "
                    f"{symbol.completed_in}, which this file does not include",
                    _COMPLETE_HERE,
                    notes=(Note("completed here", symbol.span.location),),
                )


def _declared_names(body: Iterable[DeclarationSyntax]) -> Iterator[tuple[str, int]]:
    """Yields the names of the types and constants of a file, with their lines."""
    for syntax in body:
        if isinstance(syntax, ModuleSyntax | InterfaceSyntax):
            yield from _declared_names(syntax.body)
        yield from _declared_names(_inline(syntax))
        if isinstance(syntax, TypedefSyntax):
            names = [d.name for d in syntax.declarators]
        elif isinstance(
            syntax, ImportSyntax | RepositorySyntax | AttributeSyntax | ForwardSyntax | ModuleSyntax
        ):
            names = []
        else:
            names = [syntax.name]
        for name in names:
            yield name.text, name.span.location.line


def _inline(syntax: DeclarationSyntax) -> list[DeclarationSyntax]:
    """Returns the types that are declared inside a declaration, for example by a member."""
    match syntax:
        case TypedefSyntax(type=used):
            types = [used]
        case StructSyntax(members=members):
            types = [member.type for member in members]
        case UnionSyntax(discriminator=switch, cases=cases):
            types = [switch, *(case.member.type for case in cases)]
        case _:
            types = []
    return [used.declaration for used in types if isinstance(used, InlineType)]


def _files_of(symbol: Symbol) -> set[str]:
    return _files_of_scope(symbol.scope) if symbol.scope is not None else {symbol.file}


def _files_of_scope(scope: Scope) -> set[str]:
    found: set[str] = set()
    for symbol in scope.symbols.values():
        found.add(symbol.file)
        if symbol.kind == "module":
            found |= _files_of(symbol)
    return found


def _with_repository(file: File, kept: dict[str, list[Annotation]]) -> File:
    """Adds typeid and typeprefix to the declarations of `file`, as annotations that gidl does not
    interpret."""
    declarations = []
    for declaration in file.declarations:
        extra = kept.get(declaration.name)
        if extra:
            facts = declaration.facts
            facts = replace(facts, annotations=(*facts.annotations, *extra))
            declaration = replace(declaration, facts=facts)
        declarations.append(declaration)
    return replace(file, declarations=tuple(declarations))
