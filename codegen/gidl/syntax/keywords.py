"""The keywords of IDL 4.2. Upper and lower case do not matter. A leading underscore turns a keyword
into an identifier."""

from __future__ import annotations

import keyword


def words(text: str) -> frozenset[str]:
    """Returns the set of the words in `text`, which are separated by white space."""
    return frozenset(text.split())


# Keywords that .gidl supports, or reports as unsupported. They are never identifiers.
USED = words(
    """
    any attribute bitfield bitmask bitset boolean case char const context default double enum
    exception FALSE fixed float getraises import in inout int8 int16 int32 int64 interface local
    long map module native Object octet oneway out raises readonly sequence setraises short
    string struct switch TRUE typedef typeid typeprefix uint8 uint16 uint32 uint64 union
    unsigned ValueBase valuetype void wchar wstring abstract
    """
)

# Keywords that are new in IDL 4.0. Older interfaces may use them as identifiers, for example INT8
# or Map.
NEW_IN_4 = words(
    """
    bitfield bitmask bitset int8 int16 int32 int64 map uint8 uint16 uint32 uint64
    """
)

# Keywords of the parts of IDL that .gidl does not use. They are allowed as identifiers, but gidl
# warns, because a compiler for the whole of IDL refuses them.
UNUSED = words(
    """
    alias component connector consumes custom emits eventtype factory finder home manages
    mirrorport multiple port porttype primarykey private provides public publishes supports
    truncatable typename uses
    """
)

# Keywords of C++ and Python. For each language, gidl appends an underscore to names that are
# keywords of the language.
CPP = words(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t
    char32_t class compl concept const consteval constexpr constinit const_cast continue
    co_await co_return co_yield decltype default delete do double dynamic_cast else enum
    explicit export extern false float for friend goto if inline int long mutable namespace new
    noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast requires return short signed sizeof static static_assert static_cast struct
    switch template this thread_local throw true try typedef typeid typename union unsigned
    using virtual void volatile wchar_t while xor xor_eq
    """
)
PYTHON = frozenset(keyword.kwlist)

USED_BY_LOWER = {word.lower(): word for word in USED}
UNUSED_BY_LOWER = {word.lower(): word for word in UNUSED}
