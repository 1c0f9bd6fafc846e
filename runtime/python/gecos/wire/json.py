"""Values as JSON, for people, logs and tools: `dumps` and its inverse `loads`.

Members and enumerators stand by their names, bitmasks as lists of flags, unions as
{"tag": …, "value": …}, maps as lists of pairs, bytes as lists of numbers; whole numbers of 64 bits
are exact, "nan", "inf" and "-inf" stand for themselves. Secrets are "***". C++ writes the same.
"""

from __future__ import annotations

import json
from typing import Any, TypeVar

from gecos.wire.contents import Contents, to_bytes
from gecos.wire.errors import EncodeError
from gecos.wire.shapes import JsonError, Value

__all__ = ["JsonError", "dumps", "loads"]

_ContentsT = TypeVar("_ContentsT", bound=Contents)


def dumps(value: Contents, indent: int | None = None) -> str:
    plain = Value(type(value)).plain(value)
    return json.dumps(plain, indent=indent, ensure_ascii=False, allow_nan=False)


def loads(kind: type[_ContentsT], text: str | bytes) -> _ContentsT:
    """Raises JsonError, which names the member, also for what must not be sent: a number out of
    its range, a text too long. Members that are left out have their defaults."""
    try:
        data = json.loads(text, parse_constant=_refuse, object_pairs_hook=_once)
    except (json.JSONDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise JsonError("", f"not JSON: {error}") from None
    value: _ContentsT = Value(kind).made(data, "")
    try:
        to_bytes(value)
    except EncodeError as error:
        raise JsonError(error.field, error.why) from None
    return value


def _refuse(constant: str) -> Any:
    raise JsonError("", f"not JSON: {constant}")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise JsonError(twice, "it is there twice")
    return found
