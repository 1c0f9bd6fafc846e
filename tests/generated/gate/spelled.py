"""What declarations are called in the two languages, as the wire layout says."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from gidl.files.names import python_module
from gidl.model import Model, Struct
from gidl.names.type_names import TypeName
from gidl.wire.wire_layout import Layout


def cpp(model: Model, layout: Layout, name: str) -> str:
    """The C++ type, also of a class that is written by hand."""
    declaration = model.find(name)
    if isinstance(declaration, Struct) and declaration.maps_to and declaration.maps_to.cpp:
        return f"::{declaration.maps_to.cpp[0]}"
    return _absolute(layout.cpp_names.types[name])


def cpp_servant(layout: Layout, interface: str) -> str:
    return _absolute(layout.cpp_names.servants[interface])


def cpp_results(layout: Layout, operation: str) -> str:
    return _absolute(layout.cpp_names.results[operation])


def python(model: Model, layout: Layout, name: str) -> Any:
    """The Python class."""
    module = import_module(f"{python_module(model.file_of(name))}_types")
    return getattr(module, layout.python_names.types[name].name)


def _absolute(name: TypeName) -> str:
    return "::".join(("", *name.scope, name.name))
