"""Compiled codecs of generated structs; `gecos.wire.plans` uses them."""

from collections.abc import Sequence
from typing import Any, TypeVar

_T = TypeVar("_T")

def prepare(decoder: type) -> None: ...
def struct(
    kind: type,
    fingerprint: int,
    members: Sequence[tuple[str, Any]],
    defaults: Sequence[Any],
    open: bool,
    encode: Any,
    decode: Any,
) -> tuple[Any, Any]:
    """Returns the compiled methods `encode` and `decode` of the struct `kind`."""

def from_start(decode: Any, python: _T) -> _T:
    """Returns the compiled form of `python`, a function that decodes a value from the beginning of
    bytes; `python` itself if `decode` is not compiled."""

def entry(name: str, python: _T) -> _T:
    """Returns the compiled function `name` of `gecos.wire`. In unusual cases it calls the function
    `python`."""
