"""Codecs in one go: the extension `gecos.wire._plans` does the usual case of generated structs.

What is not usual (a value that its field cannot carry, bytes that are wrong, a number that only
Python knows to be one) is left to Python, from the start; so is everything where the extension is
not there. Nobody but a clock sees the difference.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from gecos.wire.decode import Decoder

if TYPE_CHECKING:
    from gecos.wire.members import StructLayout

try:
    from gecos.wire import _plans
except ImportError:  # a tool without the extension
    COMPILED = False
else:
    COMPILED = True
    _plans.prepare(Decoder)

_FunctionT = TypeVar("_FunctionT", bound=Callable[..., Any])


def compile_struct(layout: StructLayout, fingerprint: int) -> None:
    """Puts compiled forms in the place of `encode` and `decode`, where all steps have one."""
    steps = [each.step() for each in layout.kinds]
    if None in steps or not steps:
        return
    kind, members = layout.kind, list(zip(layout.attributes, steps, strict=True))
    kind.encode, kind.decode = _plans.struct(
        kind, fingerprint, members, layout.defaults, layout.open, kind.encode, kind.decode
    )
    layout.compiled = True


def accelerated(function: _FunctionT) -> _FunctionT:
    """A function of `gecos.wire` that is compiled for the structs that have plans."""
    return _plans.entry(function.__name__, function) if COMPILED else function
