"""The verb `gecos why`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from gecos.cli.exit_codes import ExitCode, UsageFailure
from gecos.cli.options import json_option, print_json


@click.command()
@click.argument("request")
@click.option(
    "--dir",
    "folder",
    type=click.Path(path_type=Path),
    help="Folder of the audit; default: GECOS_AUDIT_DIR, else the folder of your servers.",
)
@json_option
def why(request: str, folder: Path | None, as_json: bool) -> int:
    """Says what became of REQUEST, by the audit of the servers of this user.

    REQUEST is the number at the end of a refusal, or the id of a command. The audit of a server
    belongs to the user of the server, on its host.
    """
    from gecos import _core

    place = folder or Path(_core.audit_directory())
    found = lines_about(place, _Request.of(request))
    if not found:
        raise RuntimeError(
            f"the audit in {place} has no line about {request}; either the server belongs to "
            "another user or host (ask that user), or the line was removed with the oldest file, "
            "or the server counts equal refusals in one line, which it writes within a minute"
        )
    if as_json:
        print_json(found)
    else:
        from gecos.cli.report import printable

        for line in found:
            print(printable(_sentence(line)))
    return ExitCode.FINISHED


class _Request:
    """The number of a request. It consists of the numbers of a process, of a session in the
    process, and of a call in the session."""

    __slots__ = ("counter", "session")

    def __init__(self, session: str, counter: int) -> None:
        self.session = session
        self.counter = counter

    @staticmethod
    def of(text: str) -> _Request:
        session, _, counter = text.lower().rpartition("-")
        try:
            parts = [int(part, 16) for part in (*session.split("-"), counter)]
        except ValueError:
            parts = []
        if len(parts) != 3:
            raise UsageFailure(
                f"{text} is not the number of a request: it has three parts, as 1a2b-3c4d-7"
            )
        return _Request(f"{parts[0]:x}-{parts[1]:x}", parts[2])

    def __str__(self) -> str:
        return f"{self.session}-{self.counter:x}"


def lines_about(folder: Path, request: _Request) -> list[dict[str, Any]]:
    """Returns the lines of the audit about one request, from old to new. Some lines count several
    requests instead of naming each. If no line names the request, returns the lines that count
    it."""
    mine = [line for line in _lines(folder, request.session) if "request" in line]
    about = [line for line in mine if line["request"] == str(request)]
    return about or [line for line in mine if _counts(line, request)]


def _counts(line: dict[str, Any], request: _Request) -> bool:
    if "last_request" not in line:
        return False
    first, last = (_Request.of(line[end]) for end in ("request", "last_request"))
    return first.session == request.session and first.counter <= request.counter <= last.counter


def _lines(folder: Path, part: str) -> Iterator[dict[str, Any]]:
    """Yields the lines of the audit in which `part` occurs, from old to new."""
    files = sorted(folder.glob("audit.*.jsonl"), key=_age, reverse=True)
    for file in (*files, folder / "audit.jsonl"):
        try:
            text = file.open(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            continue
        with text:
            for line in text:
                if part in line:
                    yield from _decoded(line)


def _age(file: Path) -> int:
    number = file.name.split(".")[1]
    return int(number) if number.isdecimal() else 0


def _decoded(line: str) -> Iterator[dict[str, Any]]:
    try:
        decoded = json.loads(line)
    except ValueError:
        return  # the disk was full in the middle of this line
    if isinstance(decoded, dict):
        yield decoded


_SAYS = {
    "refused": "may not connect",
    "name_refused": "may not register the object",
    "status_refused": "is refused {status} status",
    "status_granted": "has {status} status",
    "command_begins": "begins {operation}",
    "stopped": "stops the object",
}


def _sentence(line: dict[str, Any]) -> str:
    who = f"{line.get('user', '?')} on {line.get('host', '?')}"
    if "program" in line:
        who += f" ({line['program']}, pid {line.get('pid', '?')})"
    event = str(line.get("event", "?"))
    says = _SAYS.get(event, event).format_map(
        {"status": line.get("status", "?"), "operation": line.get("operation", "?")}
    )
    if event == "command":
        says = f"{line.get('operation', '?')} ended {line.get('outcome', '?')}"
    if "count" in line:
        says += f" ({line['count']} requests up to {line.get('last_request', '?')})"
    because = f": {line['why']}" if line.get("why") else ""
    return f"{line.get('time', '?')} {line.get('object', '?')}: {who}: {says}{because}"
