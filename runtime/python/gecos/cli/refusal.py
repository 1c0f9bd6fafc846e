"""Recognises the refusal of this program by the broker, whose detail is NO_SERVER."""

from __future__ import annotations

_AT_BROKER = "the broker refuses this program: "  # gecos/session/client/context.cpp


def of_broker(reason: str) -> str:
    """Returns what the broker says if `reason` is a refusal of the broker, else ""."""
    return reason.partition(_AT_BROKER)[2]
