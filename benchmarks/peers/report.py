"""What was measured, as the tables in Markdown that README.md has."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Sequence
from pathlib import Path

from measure import Measured, Pace, Rounds, Verdict
from settings import Figure, Setting


def machine(pace: Pace) -> str:
    about = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.split(": ", 1)[1] for line in about if line.startswith("model name")]
    name = names[0] if names else platform.machine()
    busy = os.getloadavg()[0]
    return (
        f"{name}, {len(os.sched_getaffinity(0))} cores, Linux {platform.release()}; medians of "
        f"{pace.rounds} rounds of {pace.seconds} s; load when it began {busy:.1f}."
    )


def bars(judged: Sequence[tuple[Setting, Verdict]]) -> str:
    rows = ["| setting | ratio | bar | measured | in the rounds | |", "|---|---|--:|--:|--:|---|"]
    for setting, verdict in judged:
        bar = verdict.bar
        other = bar.others[0] if len(bar.others) == 1 else "the best peer"
        sign = "≥" if setting.figure is Figure.RATE else "≤"
        what = f"| {setting.title} | {bar.ours} / {other} | {sign} {bar.limit:g} "
        if not verdict.ratios:
            rows.append(what + "| | | **not measured** |")
            continue
        median = statistics.median(verdict.ratios)
        word = "met" if verdict.met else "**missed**"
        spread = f"{min(verdict.ratios):.2f} to {max(verdict.ratios):.2f}"
        rows.append(f"{what}| {median:.2f} | {spread} | {word} |")
    return "\n".join(rows)


def table(setting: Setting, measured: Rounds) -> str:
    if setting.figure is Figure.RATE:
        rows = [f"| {setting.title} | calls/s | in the rounds |", "|---|--:|--:|"]
        rows += [_rate_row(label, rounds) for label, rounds in measured.items()]
    else:
        rows = [f"| {setting.title} | p50 µs | p99 µs | p50 in the rounds |", "|---|--:|--:|--:|"]
        rows += [_trips_row(label, rounds) for label, rounds in measured.items()]
    return "\n".join(rows)


def _rate_row(label: str, rounds: list[Measured]) -> str:
    rates = [one.rate for one in rounds]
    return f"| {label} | {statistics.median(rates):,.0f} | {min(rates):,.0f} to {max(rates):,.0f} |"


def _trips_row(label: str, rounds: list[Measured]) -> str:
    p50s = [one.p50 for one in rounds]
    p99 = statistics.median(one.p99 for one in rounds)
    spread = f"{min(p50s):.2f} to {max(p50s):.2f}"
    return f"| {label} | {statistics.median(p50s):.2f} | {p99:.2f} | {spread} |"
