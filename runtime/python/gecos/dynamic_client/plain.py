"""Turns plain data into values, and finds the place of a value that cannot be encoded."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from gecos.proxy import Object, reference
from gecos.wire.errors import EncodeError, JsonError
from gecos.wire.kinds import Kind, Nested, Number, below
from gecos.wire.members import BitsLayout, StructLayout
from gecos.wire.several import Entries, Items, Optional
from gecos.wire.unions import UnionLayout

_MAX_DEPTH = 100  # levels of the given data, as in gecos.wire.json


class PlainMap(Entries):
    """A map. Its plain data is either a list of pairs, as in JSON, or a dict. The keys of a dict
    may be numbers, or the texts that stand for these numbers in JSON."""

    __slots__ = ()

    def made(self, data: Any, path: str) -> Any:
        if type(data) is not dict:
            return super().made(data, path)
        entries = {}
        for name, each in data.items():
            at = f"{path}[{name!r}]"
            key = self.key.made(self._key(name), at)
            if key in entries:
                raise JsonError(at, "the map already has this key")
            entries[key] = self.value.made(each, at)
        return entries

    def _key(self, name: Any) -> Any:
        if not isinstance(self.key, Number) or type(name) is not str:
            return name
        try:
            return json.loads(name)
        except ValueError:
            return name


def plain_data(data: Any, path: str, levels: int = _MAX_DEPTH) -> Any:
    """Returns `data` in the types that `gecos.wire.json` expects. Tuples, bytes and arrays become
    lists, and a proxy becomes a reference to its object."""
    if data is None or type(data) in (bool, int, float, str):
        return data
    if levels == 0:
        raise EncodeError(path, f"nested deeper than {_MAX_DEPTH}")
    if isinstance(data, Mapping):
        return {_key(k): plain_data(v, path, levels - 1) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [plain_data(each, path, levels - 1) for each in data]
    if isinstance(data, bytes | bytearray | memoryview):
        return list(bytes(data))
    if hasattr(data, "tolist"):  # true for numbers and arrays of numpy
        return plain_data(data.tolist(), path, levels - 1)
    if isinstance(data, Object):
        object_reference = reference(data)
        names = type(object_reference).__slots__
        return {name: getattr(object_reference, name) for name in names}
    for kind in (int, float, str):
        if isinstance(data, kind):
            return kind(data)
    raise EncodeError(path, f"a value of the type {type(data).__name__} is not plain data")


def _key(name: Any) -> Any:
    for kind in (int, float, str):
        if isinstance(name, kind) and not isinstance(name, bool):
            return kind(name)
    return name


def place_of_error(kind: Kind, value: Any, path: str) -> str:
    """Returns the path of the innermost part of `value` that cannot be encoded. @pre `value` cannot
    be encoded"""
    if isinstance(kind, BitsLayout):
        return below(path, _refusal(kind, value).rpartition(".")[2])
    for inner, each, at in _parts(kind, value, path):
        try:
            inner.put(each, [], "")
        except EncodeError:
            return place_of_error(inner, each, at)
    return path


def _refusal(kind: Kind, value: Any) -> str:
    try:
        kind.put(value, [], "")
    except EncodeError as error:
        return error.field
    return ""


def _parts(kind: Kind, value: Any, path: str) -> list[tuple[Kind, Any, str]]:
    """Returns the parts of a value. A secret has no parts, so that no path shows a key of a secret
    map."""
    if isinstance(kind, Optional):
        return [] if value is None else [(kind.inner, value, path)]
    if isinstance(kind, Items):
        return [(kind.inner, each, f"{path}[{i}]") for i, each in enumerate(value)]
    if isinstance(kind, Entries):
        pairs = list(enumerate(value.items()))
        keys = [(kind.key, key, f"{path}[{i}]") for i, (key, _) in pairs]
        return keys + [(kind.value, each, f"{path}[{i}]") for i, (_, each) in pairs]
    layout = kind.layout if isinstance(kind, Nested) else None
    if isinstance(layout, StructLayout):
        members = zip(layout.names, layout.kinds, layout.attributes, strict=True)
        return [(k, getattr(value, at), below(path, name)) for name, k, at in members]
    if isinstance(layout, UnionLayout):
        arm = layout.selected(value.tag)
        parts: list[tuple[Kind, Any, str]] = []
        if arm:
            parts.append((layout.arms[arm - 1].kind, value.value, below(path, "value")))
        return parts
    return []
