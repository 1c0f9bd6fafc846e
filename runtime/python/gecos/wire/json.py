"""Converts values to JSON and back, for people, logs and tools: `dumps` and its inverse `loads`.

Members and enumerators are written by name, bitmasks as lists of flags, unions as {"tag": …,
"value": …}, maps as lists of pairs, and bytes as lists of numbers. 64-bit integers are exact. The
numbers nan, inf and -inf are texts: "nan", "inf" and "-inf". Secrets are written as "***". C++
writes the same JSON.
"""

from __future__ import annotations

import json
import math
from typing import Any, TypeVar

from gecos.wire.contents import Contents, to_bytes
from gecos.wire.errors import EncodeError, JsonError
from gecos.wire.kinds import kind_of

__all__ = ["JsonError", "NotJsonError", "dumps", "loads", "plain"]

_ContentsT = TypeVar("_ContentsT", bound=Contents)
MAX_DEPTH = 100
_LONGEST_DOUBLE = 308  # a double may not be able to represent a number with more digits


class NotJsonError(JsonError):
    """The text is not valid JSON."""


def dumps(value: Contents, indent: int | None = None) -> str:
    data = kind_of(type(value)).plain(value)
    return json.dumps(data, indent=indent, ensure_ascii=False, allow_nan=False)


def loads(kind: type[_ContentsT], text: str | bytes) -> _ContentsT:
    """Reads a value from JSON. Omitted members get their default values. Raises JsonError, which
    names the member, if the text is wrong or has a value that cannot be encoded: for example a
    number out of range, or a text that is too long."""
    value: _ContentsT = kind_of(kind).made(plain(text), "")
    try:
        to_bytes(value)
    except EncodeError as error:
        raise JsonError(error.field, error.why) from None
    return value


def plain(text: str | bytes) -> Any:
    """Reads JSON as plain data. Raises JsonError for a member that occurs twice, for a number that
    is too large for a double, and for a text that is nested too deep."""
    try:
        data = json.loads(
            text,
            parse_constant=_refuse,
            parse_float=_finite,
            parse_int=_whole,
            object_pairs_hook=_once,
        )
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise NotJsonError("", f"not JSON: {error}") from None
    except RecursionError:
        raise JsonError("", f"nested deeper than {MAX_DEPTH} levels") from None
    if _is_deeper(data, MAX_DEPTH):
        raise JsonError("", f"nested deeper than {MAX_DEPTH} levels")
    return data


def _refuse(constant: str) -> Any:
    raise JsonError("", f"not JSON: {constant}")


def _finite(text: str) -> float:
    number = float(text)
    if math.isinf(number):
        raise JsonError("", f"not JSON: {text[:40]} is too large for a number")
    return number


def _whole(text: str) -> int:
    if len(text) > _LONGEST_DOUBLE:
        _finite(text)
    return int(text)


def _is_deeper(data: Any, levels: int) -> bool:
    if not isinstance(data, dict | list):
        return False
    inside = data.values() if isinstance(data, dict) else data
    return levels == 0 or any(_is_deeper(each, levels - 1) for each in inside)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise JsonError(twice, "the member occurs twice")
    return found
