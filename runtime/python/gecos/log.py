"""What has no caller that could be told goes to stderr, in the lines of the C++ side."""

from __future__ import annotations

from gecos import _core


def error(component: str, text: str) -> None:
    """Writes each line of `text` as one of its own, so that a traceback can be read."""
    for line in text.encode(errors="backslashreplace").decode().splitlines():
        _core.log_error(component, line)
