"""Errors without a caller to report to go to stderr, in the format of the C++ log."""

from __future__ import annotations

from gecos import _core


def error(component: str, text: str) -> None:
    """Writes each line of `text` as one of its own, so that a traceback can be read."""
    for line in text.encode(errors="backslashreplace").decode().splitlines():
        _core.log_error(component, line)
