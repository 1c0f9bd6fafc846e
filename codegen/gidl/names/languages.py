"""The names that a declaration must not have in generated C++ and Python, for each kind of
declaration.

Some are keywords of the language. The others are names in generated code that a declaration would
hide: functions beside types, members of every type, and parameters and local variables of
functions.
"""

from __future__ import annotations

from pathlib import Path

from gidl.model import AnyDeclaration, Bitset, Interface, Model, Struct, Union
from gidl.names.type_names import Language, escaped
from gidl.syntax.keywords import CPP, PYTHON, words

# -- C++ -----------------------------------------------------------------------------------------


def _names_of_headers() -> tuple[frozenset[str], frozenset[str]]:
    """Returns the macros of system headers, and the names that these headers declare in the global
    namespace. The file cpp_names_of_headers.txt lists them, and says how to make the list."""
    text = (Path(__file__).parent / "cpp_names_of_headers.txt").read_text(encoding="utf-8")
    macros, others = text.partition("# Macros:\n")[2].split("# Outside of all namespaces:\n")
    return words(macros), words(others)


_MACROS, _GLOBALS = _names_of_headers()
CPP_WORDS = CPP | {"std", "tl", "nlohmann"} | _MACROS
"""Keywords, namespaces that generated code uses, and macros that system headers define."""

# Members that generated code adds to every struct. A member in the interface file that has one of
# these names gets an underscore at its end.
CPP_STRUCT_WORDS = CPP_WORDS | {"encoded_size", "encode", "decode", "fingerprint", "type_name"}
CPP_UNION_WORDS = CPP_STRUCT_WORDS | {"tag", "value", "Held"}
CPP_BITSET_WORDS = CPP_STRUCT_WORDS | {"bits", "set_bits", "raw"}

# Members of gecos::Object, of gecos::Servant, and of the proxies and servants that derive from
# them. An operation with one of these names is renamed. A parameter with one of these names is
# renamed too, because the parameter would hide the member inside the generated function.
_CPP_BASE_MEMBERS = words(
    """
    gecos_answer gecos_attach gecos_attached gecos_begins_calls gecos_call gecos_description
    gecos_detach gecos_dispatch gecos_interface gecos_lend gecos_lend_block gecos_lent
    gecos_may_publish gecos_not_published gecos_options_ gecos_publish
    gecos_publish_block gecos_publisher_ gecos_served_as gecos_session_ gecos_session_ended
    gecos_share_thread gecos_subscribe gecos_write
    """
)
CPP_METHOD_WORDS = CPP_WORDS | _CPP_BASE_MEMBERS
# In a class that derives from gecos::Object or gecos::Servant, C++ also declares the name of this
# base as a member (the injected class name).
CPP_PARAMETER_WORDS = CPP_METHOD_WORDS | {"Object", "Servant"}

# Names of functions that gidl generates in the namespaces of types. A type with one of these names
# would clash with the function.
_CPP_FUNCTIONS = words("decode_enum gecos_violation has to_string")
# Names of parameters and local variables in generated functions. Such a name would hide a constant
# or an alias with the same name, so no type or constant keeps one of these names.
_CPP_LOCALS = words(
    """
    a all arm b bases call code core description each entry field flags from guard item key main
    names number operations out outlier read result row run sample selecting self separator session
    size
    stamp_ns streams to why wrong
    """
)


def _cpp_members(model: Model, declaration: AnyDeclaration) -> set[str]:
    """Returns the names of all members of the class that is generated for `declaration`. The class
    itself must not have any of these names."""
    match declaration:
        case Struct():
            return {escaped(m.name, CPP_STRUCT_WORDS) for m in model.all_members(declaration)}
        case Union(cases=cases):
            arms = {escaped(case.member.name, CPP_UNION_WORDS) for case in cases}
            return arms | {f"make_{arm}" for arm in arms}
        case Bitset():
            fields = (field.name for field in model.all_fields(declaration))
            return {escaped(name, CPP_BITSET_WORDS) for name in fields if name is not None}
        case Interface():
            methods = {m.name for m in model.all_interface_members(declaration)}
            made = {f"{does}_{name}" for does in ("set", "publish") for name in methods}
            own = {escaped(name, CPP_METHOD_WORDS) for name in methods | made}
            return own | _CPP_BASE_MEMBERS
        case _:
            return set()


CPP_TYPES = Language(
    type_words=(CPP_UNION_WORDS | CPP_BITSET_WORDS | {"gecos"} | _CPP_FUNCTIONS | _CPP_LOCALS),
    module_words=CPP_WORDS | _CPP_FUNCTIONS,
    inner_module_words=CPP_WORDS | _CPP_FUNCTIONS | {"gecos"},
    file_is_scope=False,
    root_words=_GLOBALS,
    own_module="gecos",
    calls_are_structs=True,
    members=_cpp_members,
)

# -- Python --------------------------------------------------------------------------------------

PYTHON_WORDS = PYTHON | {"self", "cls"}
# Python builtins that generated class bodies use as type hints and decorators. A member with the
# same name would hide the builtin.
PYTHON_CLASS_WORDS = words(
    "bool bytes classmethod dict float int list object property staticmethod str"
)
# All Python builtins that generated code uses. A type with one of these names would hide the
# builtin.
PYTHON_BUILTINS = PYTHON_CLASS_WORDS | words("NotImplemented chr isinstance range tuple type")

PYTHON_TYPES = Language(
    type_words=PYTHON_WORDS
    | PYTHON_BUILTINS
    | words("annotations number other out source stamp tag value"),
    module_words=PYTHON_WORDS,
    inner_module_words=PYTHON_WORDS,
    file_is_scope=True,
)
