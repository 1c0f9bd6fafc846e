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
    """What stands in the place of `encode` and `decode`."""

def entry(name: str, python: _T) -> _T:
    """What stands in the place of the function of `gecos.wire` with this name."""
