"""Python names for the declarations of a served model. The names are the same as in generated code.

`gidl.targets.python.names` and `gidl.names.languages` have the same words and rules.
"""

from __future__ import annotations

import keyword
from collections.abc import Collection

PARAMETER_WORDS = frozenset(keyword.kwlist) | {"self", "cls"}
METHOD_WORDS = PARAMETER_WORDS | {"property", "gecos_on_stop"}
STRUCT_WORDS = PARAMETER_WORDS | {
    "bool", "bytes", "classmethod", "dict", "float", "int", "list", "object", "property",
    "staticmethod", "str", "encode", "decode", "fingerprint",
}  # fmt: skip
BITSET_WORDS = STRUCT_WORDS | {"pack", "unpack"}
EXCEPTION_WORDS = STRUCT_WORDS | {"text", "detail", "args", "add_note", "with_traceback"}
ENUM_WORDS = PARAMETER_WORDS | {
    "mro", "name", "value", "as_integer_ratio", "bit_count", "bit_length", "conjugate",
    "denominator", "from_bytes", "imag", "is_integer", "numerator", "real", "to_bytes",
}  # fmt: skip


def simple(scoped: str) -> str:
    """Returns the name without its scope, for example "Frame" for "robcl::Frame"."""
    return scoped.rpartition("::")[2]


def escaped(name: str, words: Collection[str]) -> str:
    """Returns the name of a method or an enumerator, with underscores appended if it is
    reserved."""
    plain = name.rstrip("_")
    if f"{plain}_" in words:
        return f"{name}__"
    return f"{name}_" if plain in words else name


def member_name(name: str, words: Collection[str]) -> str:
    """Returns the name of a member or a parameter, with underscores appended if it would be one of
    `words`. Names that differ only in trailing underscores all get the same number of
    underscores."""
    plain = name.rstrip("_")
    taken = (len(word) - len(plain) for word in words if word.rstrip("_") == plain)
    return name + "_" * max((more + 1 for more in taken), default=0)
