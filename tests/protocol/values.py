"""speaking::Things as the document says that it is written: by hand, no encoder of ours."""

from __future__ import annotations

import struct

from speaker.packets import block, boolean, f64, sequence, string, u32, u64

CRAWL, RUN = 1, 2


def whole(words: str, far: int) -> bytes:
    small = boolean(True) + b"\xa5" + b"g" + struct.pack(">bhH", -7, -30000, 60000)
    large = struct.pack(">iIqQ", -(2**31), 2**32 - 1, far, 2**64 - 1)
    return small + large + struct.pack(">fd", 0.5, -1e300) + string(words)


def mark(x: float, y: float, label: str) -> bytes:
    """Its base first."""
    return f64(x) + f64(y) + string(label)


def things() -> bytes:
    """What both of our clients say."""
    out = whole("grüß Gott", -(2**63)) + u32(RUN)
    out += struct.pack(">6h", 1, -2, 3, 4, 5, -6)
    out += sequence([string(""), string("two")])
    out += boolean(True) + f64(2.25) + boolean(False)
    out += sequence([mark(1.0, 2.0, "here"), mark(3.0, 4.0, "there")])
    out += u32(2) + string("a") + struct.pack(">i", -1) + string("b") + u32(2)
    out += u32(RUN) + boolean(False) + boolean(True) + string("sack")
    return out + block(u32(9) + boolean(True) + string("beside") + u32(4))


def other_things() -> bytes:
    """Whatever was there is not, and the other way round."""
    out = whole("", 2**63 - 1) + u32(CRAWL)
    out += struct.pack(">6h", 0, 0, 0, 0, 0, -32768)
    out += sequence([])
    out += boolean(False) + boolean(True) + f64(float("inf"))
    out += sequence([]) + sequence([])
    out += u32(CRAWL) + boolean(True) + f64(-0.0) + boolean(False)
    return out + block(u32(0) + boolean(False) + struct.pack(">i", -1))


def things_of_the_future() -> bytes:
    """The appendable part has a member that nobody knows here."""
    without = other_things()
    cut = len(without) - 4 - 9
    return without[:cut] + block(without[cut + 4 :] + u64(77))


def things_of_the_past() -> bytes:
    """The appendable part ends before `tries`, which is 3 where it is missing."""
    without = other_things()
    cut = len(without) - 4 - 9
    return without[:cut] + block(u32(0) + boolean(False))
