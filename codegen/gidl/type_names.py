"""Names of types, constants and interfaces in the output of one language.

A declaration keeps its simple name wherever it can. A type inside an interface or another type is
called after both (`Manipulator_Mode`), because classes cannot be reopened. A word of the language
gets an underscore at its end (`escaped`). The servant of an interface and the structs of arguments
and results are named here too, so that no two things in a scope have one name.

Operations with several results have a struct for them. The operations of the runtime's own
interfaces have one for their arguments and one for their result, because the session, which calls
and answers them, stands below proxies and servants.

The names of a file depend on what it includes and on nothing else that is compiled in the same
run, so a declaration is called the same everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    File,
    Interface,
    Model,
)


def escaped(name: str, reserved: Collection[str]) -> str:
    """`name`, with one more underscore at its end where the language or our code has that word.

    Two names stay two: beside `class`, which is written `class_`, a name `class_` is written
    `class__`.
    """
    return f"{name}_" if name.rstrip("_") in reserved else name


@dataclass(frozen=True, slots=True)
class Language:
    """Names that a language does not allow for declarations."""

    type_words: frozenset[str]  # types and constants
    module_words: frozenset[str]  # modules at the top
    inner_module_words: frozenset[str]  # modules in modules
    file_is_scope: bool  # names of modules vanish, and a file is one scope
    root_words: frozenset[str] = frozenset()  # whatever stands at the top, besides
    own_module: str = ""  # module of the runtime, and folder of the interfaces in this project
    # Names of a declaration's members, where none may be that of the type.
    members: Callable[[Model, AnyDeclaration], set[str]] = lambda _model, _declaration: set()


@dataclass(frozen=True, slots=True)
class TypeName:
    """`::geo::shapes::Point` is ("geo", "shapes") and "Point"; where files are scopes, ()."""

    scope: tuple[str, ...]
    name: str


@dataclass(frozen=True, slots=True)
class TypeNames:
    """The names in one language, by scoped name of .gidl."""

    types: dict[str, TypeName] = field(default_factory=dict)
    servants: dict[str, TypeName] = field(default_factory=dict)  # by interface
    descriptions: dict[str, TypeName] = field(default_factory=dict)  # by interface, where classes
    arguments: dict[str, TypeName] = field(default_factory=dict)  # by operation
    results: dict[str, TypeName] = field(default_factory=dict)  # by operation


def name_types(model: Model, language: Language) -> TypeNames:
    """Names all declarations of `model` in `language`."""
    naming = _Naming(model, language)
    for file in model.files:  # a file comes after those it includes
        naming.name_file(file)
    return naming.names


_Place = tuple[tuple[str, ...], str]  # a scope and a name in it


class _Naming:
    def __init__(self, model: Model, language: Language) -> None:
        self.names = TypeNames()
        self._model = model
        self._language = language
        self._taken: dict[str, set[_Place]] = {}  # by file, with what it includes
        self._top_types = language.type_words | language.root_words
        self._top_modules = language.module_words | language.root_words

    def name_file(self, file: File) -> None:
        taken: set[_Place] = set()
        if not self._language.file_is_scope:
            taken = {place for path in file.includes for place in self._taken.get(path, ())}
        declared = [d for d in file.declarations if not isinstance(d, AnnotationDeclaration)]
        for declaration in declared:
            scope = self._scope(declaration)
            taken |= {(scope[:i], scope[i]) for i in range(len(scope))}
        joined = {d.name: "_".join(self._parts(d)) for d in declared}
        wanted = {d.name: self._wanted(d, joined) for d in declared}
        # A declaration that can be called as it is written keeps its name; all others give way.
        for as_written in (True, False):
            for declaration in declared:
                name = wanted[declaration.name]
                if (name == declaration.simple_name) is as_written:
                    inside = self._language.members(self._model, declaration)
                    self.names.types[declaration.name] = _fresh(
                        self._scope(declaration), name, taken, inside
                    )
        for declaration in declared:
            if isinstance(declaration, Interface):
                self._name_companions(declaration, taken)
        self._taken[file.path] = taken

    def _name_companions(self, interface: Interface, taken: set[_Place]) -> None:
        own = self.names.types[interface.name]
        inside = self._language.members(self._model, interface)
        servant = _fresh(own.scope, f"{own.name}Servant", taken, inside)
        self.names.servants[interface.name] = servant
        if not self._language.file_is_scope:
            described = _fresh(own.scope, f"{own.name}Interface", taken, inside)
            self.names.descriptions[interface.name] = described
        in_structs = self._is_own(interface)
        for operation in interface.operations:
            wanted = f"{own.name}_{operation.name}"
            name = operation.scoped_name
            if in_structs and operation.inputs:
                self.names.arguments[name] = _fresh(own.scope, f"{wanted}_arguments", taken)
            given = len(operation.outputs) + (operation.result is not None)
            if given > 1 or (in_structs and given == 1):
                self.names.results[name] = _fresh(own.scope, f"{wanted}_result", taken)

    def _scope(self, declaration: AnyDeclaration) -> tuple[str, ...]:
        if self._language.file_is_scope:
            return ()
        modules = self._modules(declaration)
        first = tuple(self._top_module(declaration, m) for m in modules[:1])
        return first + tuple(escaped(m, self._language.inner_module_words) for m in modules[1:])

    def _top_module(self, declaration: AnyDeclaration, name: str) -> str:
        if name == self._language.own_module and not self._is_own(declaration):
            return f"{name}_"
        return escaped(name, self._top_modules)

    def _is_own(self, declaration: AnyDeclaration) -> bool:
        """Whether the declaration is the runtime's, in a language that distinguishes those."""
        own = self._language.own_module
        return bool(own) and self._model.file_of(declaration.name).startswith(f"{own}/")

    def _modules(self, declaration: AnyDeclaration) -> list[str]:
        """Modules around a declaration. Other scopes around it become part of its name."""
        modules = declaration.name.split("::")[:-1]
        while modules and self._model.has("::".join(modules)):
            modules.pop()
        return modules

    def _parts(self, declaration: AnyDeclaration) -> list[str]:
        """The parts of its name: ["Manipulator", "Mode"]."""
        return declaration.name.split("::")[len(self._modules(declaration)) :]

    def _wanted(self, declaration: AnyDeclaration, joined: dict[str, str]) -> str:
        name = joined[declaration.name]
        if self._language.file_is_scope and list(joined.values()).count(name) > 1:
            name = declaration.name.replace("::", "_")  # a::State and b::State of one file
        words = self._language.type_words
        return escaped(
            name, words if self._scope(declaration) else words | self._language.root_words
        )


def _fresh(
    scope: tuple[str, ...], wanted: str, taken: set[_Place], inside: Collection[str] = ()
) -> TypeName:
    while (scope, wanted) in taken or wanted in inside:
        wanted += "_"
    taken.add((scope, wanted))
    return TypeName(scope, wanted)
