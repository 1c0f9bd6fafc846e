"""Chooses the names of types, constants and interfaces in the output of one language.

A declaration keeps its simple name if possible. A type inside an interface or another type gets the
names of both, joined by an underscore (`Manipulator_Mode`), because C++ and Python cannot add a
type to a class later. A reserved word of the language gets an underscore at its end (`escaped`).
Servants, and structs of arguments and results, are named here too, so that the names in a scope are
unique.

An operation with several results has a struct of results. If `calls_are_structs` is True for the
language, each operation, getter and setter that has arguments also has a struct of its arguments,
and each that has a result has a struct of its result.

The names in a file depend on the file and its includes, but not on other files of the run, so a
declaration has the same name in every run.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    Attribute,
    Constant,
    File,
    Interface,
    Model,
    Operation,
    Typedef,
)


def escaped(name: str, reserved: Collection[str]) -> str:
    """Returns `name`, with underscores added at its end if the name without its last underscores,
    or with one underscore, is in `reserved`.

    Different names therefore stay different: if `class` is reserved, `class` becomes `class_`, and
    `class_` becomes `class__`. If `held_` is reserved, `held` becomes `held__`, and `held_` becomes
    `held___`.
    """
    plain = name.rstrip("_")
    if f"{plain}_" in reserved:
        return f"{name}__"
    return f"{name}_" if plain in reserved else name


@dataclass(frozen=True, slots=True)
class Language:
    """The names that a language does not allow for declarations."""

    type_words: frozenset[str]  # not allowed for types and constants
    module_words: frozenset[str]  # not allowed for modules at the top level
    inner_module_words: frozenset[str]  # not allowed for modules in modules
    file_is_scope: bool  # True: module names are dropped, and each file is one scope
    root_words: frozenset[str] = frozenset()  # not allowed for any name at the top level
    own_module: str = ""  # the runtime's own module and folder of interface files
    calls_are_structs: bool = False
    # Returns the names of the members of a declaration, which the type of the declaration must not
    # have.
    members: Callable[[Model, AnyDeclaration], set[str]] = lambda _model, _declaration: set()


@dataclass(frozen=True, slots=True)
class TypeName:
    """The scope and the name of a type in generated code, for example ("geo", "shapes") and "Point"
    for the C++ type geo::shapes::Point. In Python the scope is (), because each generated module is
    a scope of its own."""

    scope: tuple[str, ...]
    name: str


@dataclass(frozen=True, slots=True)
class TypeNames:
    """The names of declarations in one language. Keys are the scoped names in .gidl."""

    types: dict[str, TypeName] = field(default_factory=dict)
    servants: dict[str, TypeName] = field(default_factory=dict)  # key: name of the interface
    descriptions: dict[str, TypeName] = field(default_factory=dict)  # key: interface; C++ only
    # The structs of arguments. A key is the scoped name of an operation; for the setter of an
    # attribute, it is the name of the attribute and "=", for example "lab::Arm::tool=".
    arguments: dict[str, TypeName] = field(default_factory=dict)
    results: dict[str, TypeName] = field(default_factory=dict)
    # Constants and aliases in the scopes around an interface, and the classes of the interface and
    # its bases. A parameter with one of these names would hide the constant, alias or class.
    hidden: dict[str, frozenset[str]] = field(default_factory=dict)  # key: name of the interface


def name_types(model: Model, language: Language) -> TypeNames:
    """Chooses the name of every declaration of `model` in code of `language`."""
    naming = _Naming(model, language)
    for file in model.files:  # each file comes after those it includes
        naming.name_file(file)
    return naming.names


_Place = tuple[tuple[str, ...], str]  # a scope, and a name in the scope


class _Naming:
    def __init__(self, model: Model, language: Language) -> None:
        self.names = TypeNames()
        self._model = model
        self._language = language
        self._taken: dict[str, set[_Place]] = {}  # names in each file and its includes
        # The names of constants and aliases, which are a part of the names in `_taken`.
        self._values: dict[str, set[_Place]] = {}
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
        # Declarations that can keep their simple names are named first, because all other
        # declarations must get names that differ from these simple names.
        for as_written in (True, False):
            for declaration in declared:
                name = wanted[declaration.name]
                if (name == declaration.simple_name) is as_written:
                    inside = self._language.members(self._model, declaration)
                    self.names.types[declaration.name] = _fresh(
                        self._scope(declaration), name, taken, inside
                    )
        values = {place for path in file.includes for place in self._values.get(path, ())}
        values |= {
            (place.scope, place.name)
            for d in declared
            if isinstance(d, Constant | Typedef)
            for place in (self.names.types[d.name],)
        }
        interfaces = [d for d in declared if isinstance(d, Interface)]
        for interface in interfaces:
            self._name_companions(interface, taken)
        for interface in interfaces:
            around = self.names.types[interface.name].scope
            hidden = {name for scope, name in values if scope == around[: len(scope)]}
            self.names.hidden[interface.name] = frozenset(hidden | self._classes(interface))
        for interface in interfaces:
            self._name_structs_of_calls(interface, taken)
        self._taken[file.path] = taken
        self._values[file.path] = values

    def _name_companions(self, interface: Interface, taken: set[_Place]) -> None:
        own = self.names.types[interface.name]
        inside = self._language.members(self._model, interface)
        servant = _fresh(own.scope, f"{own.name}Servant", taken, inside)
        self.names.servants[interface.name] = servant
        if not self._language.file_is_scope:
            described = _fresh(own.scope, f"{own.name}Interface", taken, inside)
            self.names.descriptions[interface.name] = described

    def _classes(self, interface: Interface) -> set[str]:
        """Returns the names of the proxies and servants of an interface and of all its bases. In
        C++, the name of a class is also a member of this class and of all classes that derive from
        it."""
        tables = self.names.types, self.names.servants
        family = self._model.with_bases(interface)
        return {names[each.name].name for names in tables for each in family}

    def _name_structs_of_calls(self, interface: Interface, taken: set[_Place]) -> None:
        own, all_calls = self.names.types[interface.name], self._language.calls_are_structs
        # Result structs of operations with several results are named first. Users see these
        # structs, so no other struct should take their plain names.
        for member in sorted(interface.members, key=lambda m: _given(m) <= 1):
            wanted, name = f"{own.name}_{member.name}", member.scoped_name
            if all_calls and isinstance(member, Operation) and member.inputs:
                self.names.arguments[name] = _fresh(own.scope, f"{wanted}_arguments", taken)
            if _given(member) > 1 or (all_calls and _given(member)):
                self.names.results[name] = _fresh(own.scope, f"{wanted}_result", taken)
            if all_calls and isinstance(member, Attribute) and not member.readonly:
                setter = f"{own.name}_set_{member.name}_arguments"
                self.names.arguments[f"{name}="] = _fresh(own.scope, setter, taken)

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
        """Returns whether the declaration is in an interface file of the runtime. If the language
        has no `own_module`, returns False."""
        own = self._language.own_module
        return bool(own) and self._model.file_of(declaration.name).startswith(f"{own}/")

    def _modules(self, declaration: AnyDeclaration) -> list[str]:
        """Returns the modules that enclose a declaration. Other enclosing scopes become part of its
        name."""
        modules = declaration.name.split("::")[:-1]
        while modules and self._model.has("::".join(modules)):
            modules.pop()
        return modules

    def _parts(self, declaration: AnyDeclaration) -> list[str]:
        """Returns the parts of a declaration's name below its modules, for example ["Manipulator",
        "Mode"]."""
        return declaration.name.split("::")[len(self._modules(declaration)) :]

    def _wanted(self, declaration: AnyDeclaration, joined: dict[str, str]) -> str:
        name = joined[declaration.name]
        if self._language.file_is_scope and list(joined.values()).count(name) > 1:
            # Several declarations in the file would get this name, for example a::State and
            # b::State. Their names therefore include the modules.
            name = declaration.name.replace("::", "_")
        words = self._language.type_words
        return escaped(
            name, words if self._scope(declaration) else words | self._language.root_words
        )


def _given(member: Operation | Attribute) -> int:
    """The number of values in the reply to a call."""
    if isinstance(member, Attribute):
        return 1
    return len(member.outputs) + (member.result is not None)


def _fresh(
    scope: tuple[str, ...], wanted: str, taken: set[_Place], inside: Collection[str] = ()
) -> TypeName:
    while (scope, wanted) in taken or wanted in inside:
        wanted += "_"
    taken.add((scope, wanted))
    return TypeName(scope, wanted)
