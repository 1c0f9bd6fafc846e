"""Texts that say since when a server is silent."""

from __future__ import annotations

import time


def silent_since(silent_for: float) -> float:
    """Returns the Unix time of the last sign of life of a server. `silent_for` is how long ago that
    was, in s."""
    return time.time() - silent_for


def told(since: float) -> str:
    """Returns a text such as "silent since 12:03:07 (4.2 s)", in the local time of this host.
    `since` is the Unix time."""
    age = max(0.0, time.time() - since)
    span = f"{age:.1f} s" if age < 60 else f"{age / 60:.0f} min"
    return f"silent since {time.strftime('%H:%M:%S', time.localtime(since))} ({span})"
