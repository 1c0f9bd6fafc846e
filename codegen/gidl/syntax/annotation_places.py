"""The names of gidl's annotations, and the kinds of declarations that each may annotate."""

from __future__ import annotations

from collections.abc import Mapping

_CALLS = frozenset(("operation", "attribute"))
_OPERATION = frozenset(("operation",))
_ATTRIBUTE = frozenset(("attribute",))
_SLOTS = frozenset(("member", "parameter"))
_VALUES = _SLOTS | _CALLS | {"typedef"}
_STRUCTS = frozenset(("struct", "exception", "union"))
_CONSTRUCTED = _STRUCTS | {"enum", "bitmask", "bitset"}
_TYPES = _CONSTRUCTED | {"typedef"}

# Maps the name of an annotation to the kinds of declarations that it may annotate.
PLACES: Mapping[str, frozenset[str]] = {
    "sensor": _CALLS,
    "actor": _CALLS,
    "master": _CALLS,
    "safety": _OPERATION,
    "presence": _CALLS,
    "idempotent": _OPERATION,
    "cancelable": _OPERATION,
    "on_new": _OPERATION,
    "parallel": _OPERATION,
    "ordered": _OPERATION,
    "on_loss": _OPERATION,
    "stream": _ATTRIBUTE,
    "open_stream": _ATTRIBUTE,
    "event": _OPERATION,
    "qos": _CALLS | {"interface"},
    "unit": _VALUES | {"sequence", "constant"},
    "range": _VALUES,
    "min": _VALUES,
    "max": _VALUES,
    "default": _SLOTS,
    "default_literal": frozenset(("enumerator",)),
    "optional": _SLOTS | _CALLS,
    "id": _CALLS | {"member"},
    "value": frozenset(("enumerator",)),
    "position": frozenset(("flag",)),
    "bit_bound": frozenset(("enum", "bitmask")),
    "final": _CONSTRUCTED,
    "appendable": _CONSTRUCTED,
    "mutable": _CONSTRUCTED,
    "bulk": _SLOTS | _CALLS,
    "secret": _SLOTS | _CALLS,
    "maps_to": frozenset(("struct",)),
    "version": _TYPES | {"module", "interface"},
    "since": _TYPES | _CALLS | _SLOTS | {"interface", "enumerator", "flag", "constant"},
    "deprecated": _TYPES | _CALLS | _SLOTS | {"interface", "enumerator", "flag", "constant"},
    "hash_as": _STRUCTS | _CALLS | {"member", "interface", "enum", "bitmask", "bitset"},
}
