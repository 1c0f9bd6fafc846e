"""Compiled codecs. The extension `gecos.wire._plans` handles the usual cases of generated structs.

In an unusual case (a value that does not fit its field, invalid bytes, a number of an unusual type)
the Python codec starts again from the beginning. Without the extension, the Python codec always
runs. Both codecs give the same results, only with different speed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from gecos.wire.decode import Decoder

if TYPE_CHECKING:
    from gecos.wire.members import StructLayout

try:
    from gecos.wire import _plans
except ImportError:  # for example in a tool that runs without the extension
    COMPILED = False
else:
    COMPILED = True
    _plans.prepare(Decoder)

_T = TypeVar("_T")
_FunctionT = TypeVar("_FunctionT", bound=Callable[..., Any])


def compile_struct(layout: StructLayout, fingerprint: int) -> None:
    """Replaces `encode` and `decode` of a struct by compiled functions if the extension supports
    all steps of the layout."""
    steps = [each.step() for each in layout.kinds]
    if None in steps or not steps:
        return
    kind, members = layout.kind, list(zip(layout.attributes, steps, strict=True))
    kind.encode, kind.decode = _plans.struct(
        kind, fingerprint, members, layout.defaults, layout.open, kind.encode, kind.decode
    )
    layout.compiled = True


def accelerated(function: _FunctionT) -> _FunctionT:
    """Decorates a function of `gecos.wire`, so that structs with a compiled plan use its C++
    version."""
    return _plans.entry(function.__name__, function) if COMPILED else function


def from_start(decode: Callable[[Decoder], _T]) -> Callable[[bytes], _T]:
    """Returns a function that decodes a value from the beginning of bytes, as `decode` does from a
    `Decoder`. The function ignores the bytes after the value."""

    def decode_bytes(data: bytes) -> _T:
        return decode(Decoder(data))

    return _plans.from_start(decode, decode_bytes) if COMPILED else decode_bytes
