"""Writes the measurements as the Markdown tables of README.md."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Callable, Sequence
from pathlib import Path

from judge import Measured, Verdict
from measure import Pace, Run
from settings import Bar, Figure, Setting


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
        sign = "≥" if bar.figure.more_is_better else "≤"
        row = f"| {setting.title} | {_what(bar)} | {sign} {bar.limit:g}{_unit(bar)} "
        if not verdict.ratios:
            rows.append(row + "| | | **not measured** |")
            continue
        median = statistics.median(verdict.ratios)
        word = "met" if verdict.met else "**missed**"
        spread = f"{min(verdict.ratios):.2f} to {max(verdict.ratios):.2f}"
        rows.append(f"{row}| {median:.2f} | {spread} | {word} |")
    return "\n".join(rows)


def _what(bar: Bar) -> str:
    if not bar.others:
        return f"{bar.ours}: {bar.figure.value}"
    other = bar.others[0] if len(bar.others) == 1 else "the best peer"
    figure = "" if bar.figure is Figure.P50 else f", {bar.figure.value}"
    return f"{bar.ours} / {other}{figure}"


def _unit(bar: Bar) -> str:
    if bar.others:
        return " in 8 of 9" if bar.rounds else ""
    return {Figure.SHARE: " %", Figure.RATE: "/s", Figure.CHECKS: ""}.get(bar.figure, " µs")


def table(setting: Setting, done: Run) -> str:
    columns = {
        Figure.RATE: RATES,
        Figure.SHARE: SHARES,
        Figure.CHECKS: CHECKS,
        Figure.READABLE: IMAGES,
    }.get(setting.figure, TRIPS)
    if setting.loops is not None:
        columns = BESIDE_LOOPS
    rows = [
        f"| {setting.title} | {' | '.join(columns)} |",
        "|---|" + "--:|" * len(columns),
    ]
    for label, rounds in done.rounds.items():
        cells = [column(rounds) for column in columns.values()]
        rows.append(f"| {label} | {' | '.join(cells)} |")
    for label, times in done.repeated.items():
        rows.append(f"\nMeasured again because it failed: {label}, {times} times.")
    return "\n".join(rows)


Column = Callable[[list[Measured]], str]


def _median(figure: Figure, form: str) -> Column:
    return lambda rounds: format(statistics.median(one.figure(figure) for one in rounds), form)


def _spread(figure: Figure, form: str) -> Column:
    def column(rounds: list[Measured]) -> str:
        figures = [one.figure(figure) for one in rounds]
        return f"{min(figures):{form}} to {max(figures):{form}}"

    return column


TRIPS: dict[str, Column] = {
    "p50 µs": _median(Figure.P50, ".2f"),
    "p99 µs": _median(Figure.P99, ".2f"),
    "p50 in the rounds": _spread(Figure.P50, ".2f"),
}
RATES: dict[str, Column] = {
    "calls/s": _median(Figure.RATE, ",.0f"),
    "in the rounds": _spread(Figure.RATE, ",.0f"),
}
SHARES: dict[str, Column] = {
    "% of a core": _median(Figure.SHARE, ".3f"),
    "in the rounds": _spread(Figure.SHARE, ".3f"),
}
CHECKS: dict[str, Column] = {
    "p50 µs": _median(Figure.P50, ".3f"),
    "with / without": _median(Figure.CHECKS, ".3f"),
    "in the rounds": _spread(Figure.CHECKS, ".3f"),
}
IMAGES: dict[str, Column] = {
    "readable p50 µs": _median(Figure.READABLE, ".2f"),
    "p99 µs": _median(Figure.READABLE_P99, ".2f"),
    "p50 in the rounds": _spread(Figure.READABLE, ".2f"),
    "end to end p50 µs": _median(Figure.WHOLE, ".0f"),
    "in the rounds": _spread(Figure.WHOLE, ".0f"),
    "sending µs": _median(Figure.SENDING, ".2f"),
}
BESIDE_LOOPS: dict[str, Column] = {
    **TRIPS,
    "calls/s": _median(Figure.RATE, ",.0f"),
    "left to a loop": _median(Figure.LOOPS, ".2f"),
}
