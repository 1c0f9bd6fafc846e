"""Prints findings for other programs: as SARIF for code scanning, and as workflow commands for
GitHub Actions."""

from __future__ import annotations

import json
from collections.abc import Mapping

from gidl.diagnostics.findings import Finding, Severity
from gidl.diagnostics.source import Source
from gidl.model import Location

_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def as_sarif(
    findings: list[Finding], sources: Mapping[str, Source], titles: Mapping[str, str]
) -> str:
    """Returns the findings as a SARIF 2.1.0 report with one run. `titles` has the title of each
    code."""
    codes = sorted({f.code for f in findings})
    driver = {
        "name": "gidl",
        "rules": [
            {"id": code, "shortDescription": {"text": titles.get(code, code)}} for code in codes
        ],
    }
    results = [_result(f, codes.index(f.code), sources) for f in findings]
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    whole = {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def _result(finding: Finding, rule: int, sources: Mapping[str, Source]) -> dict[str, object]:
    text = "\n".join((finding.message, *(f"help: {line}" for line in finding.help)))
    result: dict[str, object] = {
        "ruleId": finding.code,
        "ruleIndex": rule,
        "level": finding.severity.value,
        "message": {"text": text},
    }
    if finding.location is not None:
        result["locations"] = [_place(finding.location, finding.length, sources)]
    elif finding.shown:
        artifact = {"uri": _uri(finding.shown)}
        result["locations"] = [{"physicalLocation": {"artifactLocation": artifact}}]
    if finding.notes:
        result["relatedLocations"] = [
            {"id": number, "message": {"text": note.text}, **_place(note.location, 0, sources)}
            for number, note in enumerate(finding.notes)
        ]
    return result


def _place(place: Location, length: int, sources: Mapping[str, Source]) -> dict[str, object]:
    region: dict[str, object] = {"startLine": place.line, "startColumn": place.column}
    source = sources.get(place.file)
    if source is not None and length:
        on_line = len(source.line(place.line)) - place.column + 1
        region["endColumn"] = place.column + max(1, min(length, on_line))
    artifact = {"uri": _uri(_shown(place.file, sources))}
    return {"physicalLocation": {"artifactLocation": artifact, "region": region}}


def _shown(file: str, sources: Mapping[str, Source]) -> str:
    source = sources.get(file)
    return source.shown if source else file


def _uri(shown: str) -> str:
    """Returns a path as a relative URI reference. Characters that a URI must not contain are
    percent-encoded."""
    from urllib.parse import quote

    prefix = "./" if ":" in shown.split("/")[0] else ""
    return prefix + quote(shown, safe="/.~")


def as_github_actions(findings: list[Finding], sources: Mapping[str, Source]) -> str:
    """Returns one workflow command for each finding. GitHub shows the finding beside its source
    line."""
    lines = []
    for finding in findings:
        kind = "error" if finding.severity is Severity.ERROR else "warning"
        facts = {}
        if finding.location is not None:
            facts["file"] = _shown(finding.location.file, sources)
            facts["line"] = str(finding.location.line)
            facts["col"] = str(finding.location.column)
        elif finding.shown:
            facts["file"] = finding.shown
        facts["title"] = f"gidl {finding.code}"
        said = ",".join(f"{name}={_property(text)}" for name, text in facts.items())
        text = "\n".join((finding.message, *(f"help: {line}" for line in finding.help)))
        lines.append(f"::{kind} {said}::{_data(text)}\n")
    return "".join(lines)


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
