"""Codes of number types, as in `struct` and numpy: `b B h H i I q Q f d`, and `?` for a boolean."""

from __future__ import annotations

import struct
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np


MAX_DEPTH = 16
MAX_ZERO_WIDTH = 65_536
MAX_COUNT = 2**31 - 1
MAX_TEXT = MAX_COUNT - 1


CODE_MEANING = {
    "?": "a boolean",
    "b": "a whole number from -128 to 127",
    "B": "a whole number from 0 to 255",
    "h": "a whole number from -32768 to 32767",
    "H": "a whole number from 0 to 65535",
    "i": "a whole number from -2147483648 to 2147483647",
    "I": "a whole number from 0 to 4294967295",
    "q": "a whole number from -2**63 to 2**63 - 1",
    "Q": "a whole number from 0 to 2**64 - 1",
    "f": "a number that fits in single precision",
    "d": "a number",
}
WRITERS = {code: struct.Struct(">" + code) for code in CODE_MEANING}
READERS = {code: struct.Struct(">" + code.replace("?", "B")) for code in CODE_MEANING}


@cache
def arrays(code: str) -> tuple[type[np.ndarray[Any, Any]], np.dtype[Any], np.dtype[Any], int]:
    """Returns numpy's array type, the dtype of the encoding, the native dtype, and the number of
    bytes per element. The native dtype is the same object as the `dtype` of native arrays, so that
    `is` can compare them."""
    import numpy as np

    wire = np.dtype(">" + code)
    return np.ndarray, wire, np.dtype(wire.newbyteorder("=").name), wire.itemsize


def native(code: str) -> np.dtype[Any]:
    return arrays(code)[2]
