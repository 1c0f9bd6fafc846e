"""Python names for the declarations, members and constants of an interface."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gidl.model import Attribute, Operation, Struct
from gidl.names.languages import PYTHON_CLASS_WORDS, PYTHON_WORDS
from gidl.names.type_names import escaped
from gidl.syntax.keywords import words
from gidl.targets.naming import DOC_WIDTH, LocalNames, snake_case, wrapped

# A name that is reserved in Python gets an underscore at its end. The reserved words are the words
# of gidl.names.languages and the words below. A name that generated code imports is not reserved:
# the name gets an underscore at its beginning, and no name in an interface begins with an
# underscore.
METHOD_WORDS = PYTHON_WORDS | {"property", "gecos_on_stop"}
STRUCT_WORDS = PYTHON_WORDS | PYTHON_CLASS_WORDS | {"encode", "decode", "fingerprint"}
# Declared exceptions derive from CommandFailed and BaseException, whose attributes are reserved.
EXCEPTION_WORDS = STRUCT_WORDS | {"text", "detail", "args", "add_note", "with_traceback"}
# Enumerators must not have the names of attributes of IntEnum.
ENUM_WORDS = PYTHON_WORDS | words(
    """
    mro name value as_integer_ratio bit_count bit_length conjugate denominator from_bytes imag
    is_integer numerator real to_bytes
    """
)


def mapped(struct: Struct) -> tuple[str, str] | None:
    """Returns the module and the name of the hand-written class that a struct maps to, or None."""
    return struct.maps_to.python if struct.maps_to else None


def member_name(name: str, words: frozenset[str] = STRUCT_WORDS) -> str:
    """Returns `name`, with underscores appended if `words` has this name or a name that differs
    only in underscores at its end. The same number of underscores is appended to all names that
    differ only in underscores at their ends, so that these names remain different."""
    plain = name.rstrip("_")
    taken = (len(word) - len(plain) for word in words if word.rstrip("_") == plain)
    return name + "_" * max((more + 1 for more in taken), default=0)


class Constants:
    """Chooses unique names for the constants of a module: for example `_MANIPULATOR_TOOL_OFFSET`
    for ("Manipulator", "tool_offset"). If two names become equal in capital letters, one of the two
    gets an underscore at its end."""

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


# No member of an interface has a name that one of the next two functions returns, because the rule
# gidl.rules.accessors refuses a member with such a name.
def setter(attribute: str) -> str:
    return f"set_{attribute}"


def publisher(attribute: str) -> str:
    return f"publish_{attribute}"


def lender(attribute: str) -> str:
    return f"lend_{attribute}"


def method_names(member: Operation | Attribute) -> Iterator[str]:
    """Yields the names of all methods that the proxy and the servant may have for a member of an
    interface."""
    yield method_name(member.name)
    if isinstance(member, Attribute):
        yield from (setter(member.name), publisher(member.name), lender(member.name))


def enumerator(name: str) -> str:
    return escaped(name, ENUM_WORDS)


def docstring(lines: tuple[str, ...]) -> tuple[str, ...]:
    """Returns `lines`, wrapped and escaped for a docstring in triple quotes."""
    fitting = [part for line in lines for part in wrapped(line, DOC_WIDTH)]
    quotes = '"{3,}|"+$' if len(fitting) == 1 else '"{3,}'
    return tuple(
        re.sub(quotes, lambda found: '\\"' * len(found[0]), line.replace("\\", "\\\\"))
        for line in fitting
    )
