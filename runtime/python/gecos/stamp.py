"""The time stamps that programs give to samples."""

from __future__ import annotations

_LIMIT = 9.2e9  # s; a stamp is sent in ns, as a signed number of 64 bits


def in_ns(stamp: float | None) -> int | None:
    """Converts a stamp in s of Unix time to ns; None stays None. Raises ValueError if the stamp is
    no such time, for example because it is in ms."""
    if stamp is None:
        return None
    if not abs(stamp) < _LIMIT:
        raise ValueError(
            f"stamp cannot be {stamp}: it is the time of measurement in s of Unix time, as "
            "time.time() returns it"
        )
    return round(stamp * 1e9)
