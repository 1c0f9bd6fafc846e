"""Counts of a stream, as the tests of both languages write them."""

from gecos_idl.object_types import FeedReport

COUNTS = (
    "lost",
    "other_session",
    "session_ended",
    "no_status",
    "command_not_running",
    "too_old",
    "not_newer",
    "unreadable",
)


def in_words(report: FeedReport) -> str:
    """Counts that are 0 are left out."""
    counts = [f"admitted {report.admitted}"]
    counts += [f"{name} {getattr(report, name)}" for name in COUNTS if getattr(report, name)]
    why = f"; {report.last_refusal}" if report.last_refusal else ""
    return ", ".join(counts) + why
