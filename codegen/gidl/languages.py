"""The words that generated C++ and Python keep for themselves, by what must not be called so.

The language has some of them; the others are names of ours that a declaration would hide: functions
beside types, members that every type has, parameters and locals of the bodies.
"""

from __future__ import annotations

from gidl.keywords import CPP, PYTHON, words
from gidl.type_names import Language

# -- C++ -----------------------------------------------------------------------------------------

_MACROS = words(
    """
    assert errno stdin stdout stderr offsetof alloca NULL TRUE FALSE DOMAIN EOF NAN INFINITY
    HUGE_VAL BIG_ENDIAN LITTLE_ENDIAN BYTE_ORDER
    """
)
CPP_WORDS = CPP | {"std", "tl"} | _MACROS
"""Keywords, the namespaces that generated code names, and the macros that headers bring along."""

# Members that every generated struct has besides its own.
CPP_STRUCT_WORDS = CPP_WORDS | {"encoded_size", "encode", "decode", "fingerprint", "type_name"}
CPP_UNION_WORDS = CPP_STRUCT_WORDS | {"tag", "value", "Held"}
CPP_BITSET_WORDS = CPP_STRUCT_WORDS | {"bits", "set_bits", "raw"}

_CPP_TYPE_WORDS = (
    CPP_UNION_WORDS
    | CPP_BITSET_WORDS
    | words(
        """
        a arm b call code core decode_enum entry field flags from gecos guard has item key main
        names number out read result row run selecting separator session size stamp_ns to
        to_string why wrong
        """
    )
)

CPP_TYPES = Language(
    type_words=_CPP_TYPE_WORDS,
    module_words=CPP_WORDS,
    inner_module_words=CPP_WORDS | {"gecos"},
    file_is_scope=False,
)

# -- Python --------------------------------------------------------------------------------------

PYTHON_WORDS = PYTHON | {"self", "cls"}
# Builtins that stand in the body of a class beside its members, as hints and decorators.
PYTHON_CLASS_WORDS = words(
    "bool bytes classmethod dict float int list object property staticmethod str"
)
# Builtins that generated code names anywhere.
PYTHON_BUILTINS = PYTHON_CLASS_WORDS | words("NotImplemented chr isinstance range tuple type")

PYTHON_TYPES = Language(
    type_words=PYTHON_WORDS
    | PYTHON_BUILTINS
    | words("annotations number other out source stamp tag value"),
    module_words=PYTHON_WORDS,
    inner_module_words=PYTHON_WORDS,
    file_is_scope=True,
)
