"""Finds the headers of the standard library that the text of a declaration needs."""

from __future__ import annotations

import re
from collections.abc import Iterable

_HEADERS = {
    "array": "array", "int8_t": "cstdint", "int16_t": "cstdint", "int32_t": "cstdint",
    "int64_t": "cstdint", "map": "map", "numeric_limits": "limits", "optional": "optional",
    "string": "string", "string_view": "string_view", "uint8_t": "cstdint", "uint16_t": "cstdint",
    "uint32_t": "cstdint", "uint64_t": "cstdint", "variant": "variant", "vector": "vector",
}  # fmt: skip


def system_headers(texts: Iterable[str]) -> set[str]:
    """Returns the standard headers that declare the names in `texts`. A generated header includes
    all standard headers that it needs, and does not rely on the headers that its own headers
    include."""
    used = {word for text in texts for word in re.findall(r"\bstd::(\w+)", text)}
    return {_HEADERS[word] for word in used if word in _HEADERS}
