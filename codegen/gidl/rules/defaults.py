"""Rule: a default must be inside the range of its member, and a member with a default must not be
@optional."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Model
from gidl.rules.walk import Slot, slots


def check(model: Model, findings: Findings) -> None:
    for slot in slots(model):
        if slot.default is None:
            continue
        at = slot.facts.place_of("default")
        if slot.optional:
            findings.error(
                "G0508",
                at,
                f"{slot.what} cannot have both @default and @optional",
                "keep @default if a reader should take the default for a missing value; otherwise "
                "keep @optional",
            )
        _in_range(slot, findings)


def _in_range(slot: Slot, findings: Findings) -> None:
    bounds, value = slot.range, slot.default
    if bounds is None or isinstance(value, bool) or not isinstance(value, int | float):
        return
    low, high = bounds.minimum, bounds.maximum
    if (low is not None and value < low) or (high is not None and value > high):
        allowed = f"{'' if low is None else low} to {'' if high is None else high}".strip()
        findings.error(
            "G0309",
            slot.facts.place_of("default"),
            f"the default {value} of {slot.what} is outside its range {allowed}",
        )
