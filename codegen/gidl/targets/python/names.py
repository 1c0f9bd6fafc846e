"""How the names of an interface are written in Python, and where they live."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from gidl.file_names import python_module
from gidl.languages import PYTHON_CLASS_WORDS, PYTHON_TYPES, PYTHON_WORDS
from gidl.model import File, Interface, Model, Struct
from gidl.targets.naming import LocalNames, UnsupportedError, snake_case
from gidl.type_names import escaped

# What a name cannot be in Python gets an underscore behind. All that generated code needs of the
# runtime and the standard library has one in front, as no name of an interface has; what is left
# are the words of gidl.languages and those below.
METHOD_WORDS = PYTHON_WORDS | {"property"}
STRUCT_WORDS = PYTHON_WORDS | PYTHON_CLASS_WORDS | {"encode", "decode", "fingerprint"}
# A declared exception also is a CommandFailed and a BaseException.
EXCEPTION_WORDS = STRUCT_WORDS | {"text", "detail", "args", "add_note", "with_traceback"}
# What an enumerator cannot be called.
ENUM_WORDS = PYTHON_WORDS | {"mro", "name", "value"}

# What a value of an interface's type is, and where that is declared.
OBJECT_REF = "gecos::ObjectRef"
OBJECT_REF_FILE = "gecos/object_ref.gidl"


def type_name(model: Model, scoped_name: str) -> str:
    """`robcl::Manipulator::Mode` is called `Manipulator_Mode`, like everywhere in our output."""
    parts = scoped_name.split("::")
    modules = len(parts) - 1
    while modules and model.has("::".join(parts[:modules])):
        modules -= 1
    return escaped("_".join(parts[modules:]), PYTHON_TYPES.type_words)


def refuse_same_names(model: Model, file: File, used: Iterable[str]) -> None:
    """Raises UnsupportedError where two types that a file has are one name in Python."""
    scoped_names: dict[str, str] = {}
    for name in [*(d.name for d in file.declarations), *filter(model.has, sorted(used))]:
        simple = type_name(model, name)
        other = scoped_names.setdefault(simple, name)
        if other == name:
            continue
        here = next((d for d in file.declarations if d.name in (other, name)), file.declarations[0])
        raise UnsupportedError(
            here.facts.location,
            f"{other} and {name} are both {simple} in Python, and {file.path} has both;"
            " give one of them another name",
        )


def value_name(model: Model, scoped_name: str) -> str:
    """The class of a value of that type: of an interface's, a reference to an object."""
    if model.has(scoped_name) and isinstance(model.find(scoped_name), Interface):
        scoped_name = OBJECT_REF
    return type_name(model, scoped_name)


def types_module(model: Model, scoped_name: str) -> str:
    """The module that has the class of a value of that type."""
    home = OBJECT_REF_FILE if scoped_name == OBJECT_REF else model.file_of(scoped_name)
    return f"{python_module(home)}_types"


def mapped(struct: Struct) -> tuple[str, str] | None:
    """Module and name of the hand-written type, where there is one."""
    return struct.maps_to.python if struct.maps_to else None


def member_name(name: str, words: frozenset[str] = STRUCT_WORDS) -> str:
    return escaped(name, words)


class Constants:
    """What a module calls its own constants: ("Manipulator", "tool_offset") is
    `_MANIPULATOR_TOOL_OFFSET`. Each has a name of its own, also where capitals make two alike."""

    def __init__(self) -> None:
        self._taken = LocalNames()
        self._names: dict[tuple[str, ...], str] = {}

    def name(self, *words: str) -> str:
        if words not in self._names:
            plain = "_" + "_".join(snake_case(word) for word in words).upper().lstrip("_")
            self._names[words] = self._taken.fresh(plain)
        return self._names[words]


def method_names(model: Model, interface: Interface) -> LocalNames:
    return LocalNames(method_name(m.name) for m in model.all_interface_members(interface))


def method_name(name: str) -> str:
    return escaped(name, METHOD_WORDS)


def enumerator(name: str) -> str:
    return escaped(name, ENUM_WORDS)


def docstring(lines: tuple[str, ...]) -> tuple[str, ...]:
    """The lines as they can stand between three quotes."""
    fitting = [part for line in lines for part in textwrap.wrap(line, 86) or [""]]
    safe = [line.replace("\\", "\\\\").replace('"""', '\\"\\"\\"') for line in fitting]
    if len(safe) == 1 and safe[0].endswith('"'):
        safe[0] = safe[0][:-1] + '\\"'
    return tuple(safe)
