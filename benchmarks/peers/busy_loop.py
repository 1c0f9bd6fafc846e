"""busy_loop.py CORE NICE SLICE_MS: never sleeps. SLICE_MS 0 leaves its time slice to the scheduler.

Says "looping", or why the kernel gives it no slice of its own (Linux does from 6.12 on).
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys

SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}


def set_slice(nice: int, slice_ms: float) -> str:
    """The reason why it cannot be set, or nothing."""
    number = SCHED_SETATTR.get(platform.machine())
    if number is None:
        return f"no time slices on {platform.machine()}"
    # size, policy, flags, nice, priority, runtime: of SCHED_OTHER the slice; deadline, period
    attributes = struct.pack("IIQiIQQQ", 48, 0, 0, nice, 0, int(slice_ms * 1e6), 0, 0)
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.syscall(number, 0, ctypes.create_string_buffer(attributes, 48), 0) == 0:
        return ""
    return f"no time slices: {os.strerror(ctypes.get_errno())}"


def main() -> None:
    core, nice, slice_ms = sys.argv[1:]
    os.sched_setaffinity(0, {int(core)})
    os.nice(int(nice))
    print((set_slice(int(nice), float(slice_ms)) if float(slice_ms) else "") or "looping")
    sys.stdout.flush()
    while True:
        pass


if __name__ == "__main__":
    main()
