"""Helper functions of generated types and of the codec."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from gecos.wire.codes import native

if TYPE_CHECKING:
    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[Any]


def signed(bits: int, width: int) -> int:
    """Returns the number that the lowest `width` bits represent in two's complement."""
    return bits - (1 << width) if bits >> (width - 1) else bits


def first(entry: tuple[Any, Any]) -> Any:
    """Returns the key of an entry of a map; `sorted` uses it to sort the entries."""
    return entry[0]


def zeros(code: str, *shape: int) -> Array:
    """Returns the initial value of an array member: all elements are 0."""
    import numpy as np

    return np.zeros(shape, native(code))


def as_array(values: npt.ArrayLike, code: str) -> Array:
    """Returns `values` as a numpy array. A bytes object becomes an array of numbers only for the
    code `B`."""
    import numpy as np

    if code == "B" and isinstance(values, bytes):
        return np.frombuffer(values, np.uint8)
    return np.asarray(values)


def _numbers(value: Any) -> Any:
    """Converts bytes to an array of numbers, so that they can be compared with arrays. Returns
    other values unchanged."""
    import numpy as np

    given = isinstance(value, bytes | bytearray | memoryview)
    return np.frombuffer(value, np.uint8) if given else value


def same(left: Any, right: Any) -> bool:
    """Returns whether two values that may hold arrays are equal."""
    if isinstance(left, list) or isinstance(right, list):
        sized = hasattr(left, "__len__") and hasattr(right, "__len__")
        return sized and len(left) == len(right) and all(map(same, left, right))
    if isinstance(left, dict) and isinstance(right, dict):
        return left.keys() == right.keys() and all(same(left[key], right[key]) for key in left)
    if left is None or right is None:
        return left is right
    left, right = _numbers(left), _numbers(right)
    equal = left == right
    if hasattr(equal, "all"):
        return bool(equal.all()) and left.shape == right.shape
    return bool(equal)
