"""Recognises that the broker refuses this program. Such a refusal has the detail NO_SERVER, as has
an object that is not online, so only the text of the reason tells the two apart."""

from __future__ import annotations

_AT_BROKER = "the broker refuses this program: "  # gecos/session/client/context.cpp


def of_broker(reason: str) -> str:
    """Returns what the broker says if `reason` is a refusal of the broker, else ""."""
    return reason.partition(_AT_BROKER)[2]
