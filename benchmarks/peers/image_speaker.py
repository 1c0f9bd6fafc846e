"""Images, for readers in Python; images.hpp says what they are and what is measured."""

from __future__ import annotations

import ctypes
import struct
import sys
import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from speaker import answer_each, of_the_clock, quantile

Octets = npt.NDArray[np.uint8]
Next = Callable[[], tuple[Octets, Callable[[], bool]]]
"""Waits for an image that was not yet read: its octets, and whether they are still the same."""

STAMPS = struct.Struct("=Qqqq")

_memcmp = ctypes.CDLL(None).memcmp
_memcmp.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t)


def speak(next_image: Next) -> None:
    """Answers every line of standard input with a line, until there is no more."""

    def answer(words: list[str]) -> str | None:
        match words:
            case ["images", seconds]:
                return _images(next_image, float(seconds))
        return None

    answer_each(answer)


def _images(next_image: Next, seconds: float) -> str:
    readable: list[int] = []
    whole: list[int] = []
    sending: list[int] = []
    lost = 0
    asked = time.monotonic_ns()
    end = asked + int(seconds * 1e9)
    while time.monotonic_ns() < end if readable else lost < 10:
        octets, intact = next_image()
        arrived = time.monotonic_ns()
        number, begun, sent, before = STAMPS.unpack_from(octets)
        same = _of_one_image(octets[STAMPS.size :], number)
        read = time.monotonic_ns()
        if not intact():
            lost += 1
            continue
        if not same:
            sys.exit("the octets are not those of one image")
        if begun >= asked:  # one that is older may have waited here for the question
            readable.append(arrived - sent)
            whole.append(read - begun)
            sending.append(before)
    if lost > len(readable) // 10 + 1:
        sys.exit("images were overwritten")
    clock = of_the_clock()
    figures = [
        quantile(times, part) - clock
        for times, part in (
            (readable, 0.5), (readable, 0.99), (whole, 0.5), (whole, 0.99), (sending, 0.5)
        )
    ]  # fmt: skip
    return " ".join(map(str, [len(readable), *figures]))


def _of_one_image(octets: Octets, number: int) -> bool:
    """Reads every octet: each must equal the one before. numpy would make two passes."""
    at, size = octets.ctypes.data, octets.size
    return bool(octets[0] == number % 256) and _memcmp(at, at + 1, size - 1) == 0
