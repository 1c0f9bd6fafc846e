"""Writes errors to stderr that no caller can receive, in the format of the C++ log."""

from __future__ import annotations

from gecos import _core


def error(component: str, text: str) -> None:
    """Writes each line of `text` as a separate log line, so that tracebacks stay readable."""
    for line in text.encode(errors="backslashreplace").decode().splitlines():
        _core.log_error(component, line)
