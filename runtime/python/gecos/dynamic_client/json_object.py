"""Checked access to the entries of a JSON object that comes from another program."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection
from typing import Any, TypeVar

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_SCOPED = re.compile(r"[A-Za-z][A-Za-z0-9_]*(?:::[A-Za-z][A-Za-z0-9_]*)*", re.ASCII)
_HEX64 = re.compile(r"0x[0-9a-f]{1,16}", re.ASCII)
_LARGEST = 1 << 1000

T = TypeVar("T")


class Malformed(ValueError):
    """An entry is missing or wrong. The text names the place of the entry."""


def parse_object(text: str, place: str) -> JsonObject:
    try:
        data = json.loads(text, object_pairs_hook=_once, parse_constant=_refuse)
    # A ValueError means that the text is not JSON, or that a number in it is too long.
    except (ValueError, RecursionError) as error:
        raise Malformed(f"{place} is not JSON: {str(error)[:200]}") from None
    return JsonObject(data, place)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("an object has two entries with the same name")
    return found


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant} is not a JSON number")


class JsonObject:
    """A JSON object. Each method reads one entry. The method raises `Malformed` if the entry has
    another type, or if the entry is missing and `otherwise` is not given."""

    def __init__(self, data: Any, place: str) -> None:
        if type(data) is not dict:
            raise Malformed(f"{place} is not an object")
        self._data: dict[str, Any] = data
        self.place = place

    def has(self, key: str) -> bool:
        return key in self._data

    def raw(self, key: str) -> Any:
        return self._data.get(key)

    def _typed(self, key: str, wanted: str, kinds: tuple[type, ...], otherwise: T | None) -> Any:
        if key not in self._data:
            if otherwise is None:
                raise Malformed(f"{self.place} has no '{key}'")
            return otherwise
        value = self._data[key]
        if type(value) not in kinds:
            raise Malformed(f"'{key}' of {self.place} is not {wanted}")
        return value

    def text(self, key: str, otherwise: str | None = None) -> str:
        value: str = self._typed(key, "a text", (str,), otherwise)
        return value

    def name(self, key: str = "name") -> str:
        return self._matching(key, _NAME, "a name")

    def scoped(self, key: str = "name") -> str:
        return self._matching(key, _SCOPED, "a scoped name")

    def scoped_or_none(self, key: str) -> str:
        return self.scoped(key) if self.has(key) else ""

    def _matching(self, key: str, pattern: re.Pattern[str], wanted: str) -> str:
        value = self.text(key)
        if pattern.fullmatch(value) is None:
            raise Malformed(f"'{key}' of {self.place} is not {wanted}")
        return value

    def flag(self, key: str, otherwise: bool = False) -> bool:
        value: bool = self._typed(key, "true or false", (bool,), otherwise)
        return value

    def whole(self, key: str, low: int, high: int, otherwise: int | None = None) -> int:
        value: int = self._typed(key, "a whole number", (int,), otherwise)
        if not low <= value <= high:
            raise Malformed(f"'{key}' of {self.place} is not from {low} to {high}")
        return value

    def number(self, key: str) -> int | float | None:
        """Returns a finite number, or None if the entry is missing."""
        if key not in self._data:
            return None
        value: int | float = self._typed(key, "a number", (int, float), None)
        if not -_LARGEST <= value <= _LARGEST:  # a float beyond this limit is infinite
            raise Malformed(f"'{key}' of {self.place} is too large for a number")
        return value

    def hash(self, key: str) -> int:
        return int(self._matching(key, _HEX64, "a hexadecimal number of 64 bits"), 16)

    def one_of(self, key: str, known: Collection[str], otherwise: str | None = None) -> str:
        value = self.text(key, otherwise)
        if value not in known:
            raise Malformed(f"'{key}' of {self.place} is none of {', '.join(known)}")
        return value

    def inner(self, key: str) -> JsonObject | None:
        if key not in self._data:
            return None
        return JsonObject(self._data[key], f"'{key}' of {self.place}")

    def list_of(self, key: str, read: Callable[[JsonObject], T]) -> tuple[T, ...]:
        """Returns the elements of a list of objects; an empty tuple if the entry is missing."""
        found: list[Any] = self._typed(key, "a list", (list,), [])
        named = f"'{key}' of {self.place}"
        return tuple(read(JsonObject(each, f"{named}[{i}]")) for i, each in enumerate(found))

    def scoped_names(self, key: str) -> tuple[str, ...]:
        found: list[Any] = self._typed(key, "a list", (list,), [])
        for each in found:
            if type(each) is not str or _SCOPED.fullmatch(each) is None:
                raise Malformed(f"'{key}' of {self.place} is not a list of scoped names")
        return self.distinct(key, found)

    def distinct(self, key: str, names: Collection[str]) -> tuple[str, ...]:
        """Returns `names`, which come from the entry `key`. Raises `Malformed` if a name occurs
        twice."""
        found = tuple(names)
        if len(set(found)) != len(found):
            twice = next(name for name in found if found.count(name) > 1)
            raise Malformed(f"'{key}' of {self.place} has {twice} twice")
        return found
