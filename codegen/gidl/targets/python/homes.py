"""Finds the modules that define generated classes, and the names under which a module imports
them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from gidl.files.names import python_module
from gidl.model import File, Interface, Model, Operation, Struct
from gidl.targets.naming import LocalNames
from gidl.wire.wire_layout import Layout

# If the declared type of a value is an interface, the value has the type ObjectRef. The first
# constant is the scoped name of ObjectRef, the second the path of the file that declares ObjectRef.
OBJECT_REF = "gecos::ObjectRef"
_OBJECT_REF_FILE = "gecos/object_ref.gidl"


class Home(NamedTuple):
    """The module that defines a class, and the name of the class in that module."""

    module: str
    name: str


class Homes:
    """Finds the module and the name of the class that is generated for a declaration."""

    def __init__(self, model: Model, layout: Layout) -> None:
        self._model = model
        self._names = layout.python_names

    def value(self, scoped_name: str) -> Home:
        """Returns the module and the name of the class of a value whose declared type is
        `scoped_name`. If the type is an interface, the class is ObjectRef."""
        if scoped_name != OBJECT_REF and isinstance(self._model.find(scoped_name), Interface):
            scoped_name = OBJECT_REF
        if scoped_name == OBJECT_REF and not self._model.has(OBJECT_REF):
            return Home(f"{python_module(_OBJECT_REF_FILE)}_types", "ObjectRef")
        name = self._names.types[scoped_name].name
        return Home(self._types_module(scoped_name), name)

    def proxy(self, interface: str) -> Home:
        return Home(self._module(interface), self._names.types[interface].name)

    def servant(self, interface: str) -> Home:
        return Home(self._module(interface), self._names.servants[interface].name)

    def result(self, operation: Operation) -> Home:
        """Returns the module and the name of the result class of an operation with several
        results."""
        name = self._names.results[operation.scoped_name].name
        return Home(self._types_module(operation.interface), name)

    def results_of(self, file: File) -> list[Operation]:
        """Returns the operations of a file that have several results."""
        interfaces = [d for d in file.declarations if isinstance(d, Interface)]
        known = self._names.results
        return [o for i in interfaces for o in i.operations if o.scoped_name in known]

    def names_of(self, file: File) -> set[str]:
        """Returns all names that the modules of a file define."""
        known = self._names
        declared = [d.name for d in file.declarations]
        found = [
            table[name]
            for table in (known.types, known.servants)
            for name in declared
            if name in table
        ]
        found += [known.results[operation.scoped_name] for operation in self.results_of(file)]
        return {each.name for each in found}

    def _module(self, declaration: str) -> str:
        return python_module(self._model.file_of(declaration))

    def _types_module(self, declaration: str) -> str:
        return f"{self._module(declaration)}_types"


class ModuleNames:
    """The names by which one module refers to classes. An imported class keeps its name if this
    name is free in the module. Otherwise the class is imported under an alias, which cannot be the
    name of a declaration."""

    def __init__(
        self,
        homes: Homes,
        used: Iterable[Home] = (),
        taken: Iterable[str] = (),
        own_modules: Iterable[str] = (),
    ) -> None:
        """Chooses the names for one module. `used` are the classes that the module uses. Classes of
        `own_modules` are not imported. `taken` are all names that the module itself defines."""
        self.homes = homes
        self._own = frozenset(own_modules)
        self._here = set(taken)
        self._imported: dict[Home, str] = {}
        for home in sorted(home for home in set(used) if home.module not in self._own):
            self._import(home)

    def _import(self, home: Home) -> None:
        called = home.name
        if called in self._here:
            alias = f"_{called}__{home.module.replace('.', '_')}"
            called = LocalNames(self._here).fresh(alias)
        self._here.add(called)
        self._imported[home] = called

    def value(self, scoped_name: str) -> str:
        return self._called(self.homes.value(scoped_name))

    def proxy(self, interface: str) -> str:
        return self._called(self.homes.proxy(interface))

    def servant(self, interface: str) -> str:
        return self._called(self.homes.servant(interface))

    def result(self, operation: Operation) -> str:
        return self._called(self.homes.result(operation))

    def imports(self) -> dict[str, set[str]]:
        """Returns the names to import from each module, for example "Frame" or "Frame as
        _Frame__lab_types"."""
        modules: dict[str, set[str]] = {}
        for home, called in self._imported.items():
            text = home.name if called == home.name else f"{home.name} as {called}"
            modules.setdefault(home.module, set()).add(text)
        return modules

    def _called(self, home: Home) -> str:
        return home.name if home.module in self._own else self._imported[home]


class NamesAsUsed(ModuleNames):
    """The names by which a module refers to classes, for a module whose classes are not known
    beforehand. A class is added to the imports when its name is requested for the first time."""

    def __init__(self, homes: Homes, taken: Iterable[str]) -> None:
        super().__init__(homes)
        self._here = set(taken)

    def _called(self, home: Home) -> str:
        if home not in self._imported:
            self._import(home)
        return self._imported[home]


class AllNames(ModuleNames):
    """The names that classes have in the modules that define them. A text uses these names if the
    classes are not imported for the text."""

    def _called(self, home: Home) -> str:
        return home.name


def mapped_import(struct: Struct, called: str) -> tuple[str, str]:
    """Returns the two parts of a statement that imports the hand-written class under the name
    `called`: the module, and the text after `import`."""
    assert struct.maps_to is not None and struct.maps_to.python is not None
    module, name = struct.maps_to.python
    return module, name if name == called else f"{name} as {called}"
