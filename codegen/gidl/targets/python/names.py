"""How the names of an interface are written in Python, and where they live."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gidl.keywords import words
from gidl.languages import PYTHON_CLASS_WORDS, PYTHON_WORDS
from gidl.model import Attribute, Operation, Struct
from gidl.targets.naming import LocalNames, snake_case, wrapped
from gidl.type_names import escaped

# What a name cannot be in Python gets an underscore after. All that generated code needs of the
# runtime and the standard library has one in front, as no name of an interface has; what is left
# are the words of gidl.languages and those below.
METHOD_WORDS = PYTHON_WORDS | {"property", "gecos_on_stop"}
STRUCT_WORDS = PYTHON_WORDS | PYTHON_CLASS_WORDS | {"encode", "decode", "fingerprint"}
# A declared exception also is a CommandFailed and a BaseException.
EXCEPTION_WORDS = STRUCT_WORDS | {"text", "detail", "args", "add_note", "with_traceback"}
# What an enumerator cannot be called: what an enum has, and the whole number that it is.
ENUM_WORDS = PYTHON_WORDS | words(
    """
    mro name value as_integer_ratio bit_count bit_length conjugate denominator from_bytes imag
    is_integer numerator real to_bytes
    """
)


def mapped(struct: Struct) -> tuple[str, str] | None:
    """Module and name of the hand-written type, where there is one."""
    return struct.maps_to.python if struct.maps_to else None


def member_name(name: str, words: frozenset[str] = STRUCT_WORDS) -> str:
    """`name`, with underscores after it where it is one of `words`. Two names stay two: of names
    that differ in underscores alone, each gets as many more as keep the first from all `words`."""
    plain = name.rstrip("_")
    taken = (len(word) - len(plain) for word in words if word.rstrip("_") == plain)
    return name + "_" * max((more + 1 for more in taken), default=0)


class Constants:
    """A module's names for its own constants: ("Manipulator", "tool_offset") is
    `_MANIPULATOR_TOOL_OFFSET`. Each has a name of its own, also where capitals make two alike."""

    def __init__(self) -> None:
        self._taken = LocalNames()
        self._names: dict[tuple[str, ...], str] = {}

    def name(self, *words: str) -> str:
        if words not in self._names:
            plain = "_" + "_".join(snake_case(word) for word in words).upper().lstrip("_")
            self._names[words] = self._taken.fresh(plain)
        return self._names[words]


def method_name(name: str) -> str:
    return escaped(name, METHOD_WORDS)


# The rules of the compiler exclude members with the names of these two methods.
def setter(attribute: str) -> str:
    return f"set_{attribute}"


def publisher(attribute: str) -> str:
    return f"publish_{attribute}"


def method_names(member: Operation | Attribute) -> Iterator[str]:
    """All that proxy and servant have for a member."""
    yield method_name(member.name)
    if isinstance(member, Attribute):
        yield from (setter(member.name), publisher(member.name))


def enumerator(name: str) -> str:
    return escaped(name, ENUM_WORDS)


def docstring(lines: tuple[str, ...]) -> tuple[str, ...]:
    """The lines as they can stand between three quotes."""
    fitting = [part for line in lines for part in wrapped(line, 86)]
    quotes = '"{3,}|"+$' if len(fitting) == 1 else '"{3,}'
    return tuple(
        re.sub(quotes, lambda found: '\\"' * len(found[0]), line.replace("\\", "\\\\"))
        for line in fitting
    )
