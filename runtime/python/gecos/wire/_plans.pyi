"""Codecs of generated structs, carried out in one go; `gecos.wire.plans` tells them."""

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
    """The compiled `encode` and `decode`."""

def entry(name: str, python: _T) -> _T:
    """The compiled function of `gecos.wire` with this name."""
