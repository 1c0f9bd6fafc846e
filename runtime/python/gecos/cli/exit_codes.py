"""The exit codes of the command `gecos`, and the failures for which they stand.

0: the command FINISHED. 1: the environment is wrong, for example a setting is not valid. 2: wrong
usage. 3: COMMAND_FAILED. 4: CONNECTION_FAILED. 5: access was DENIED or REFUSED (used instead of 3
and 4). 130: ended by Ctrl-C.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import click

from gecos.errors import (
    CommandFailed,
    ConnectionFailed,
    CreateError,
    DeclaredError,
    Detail,
    LeaseRefused,
    State,
)
from gecos.wire import EncodeError, JsonError


class ExitCode(IntEnum):
    FINISHED = 0
    ENVIRONMENT = 1
    USAGE = 2
    COMMAND_FAILED = 3
    CONNECTION_FAILED = 4
    NO_ACCESS = 5
    INTERRUPTED = 130


class UsageFailure(ValueError):
    """The command line names an object, a member or a file that does not exist or cannot be used,
    or it contains a value that is not accepted."""


class NotEnded(TimeoutError):
    """The verb stopped waiting for a command after `--timeout`. `detail` says whether the command
    was canceled or still runs."""

    def __init__(self, detail: Detail, text: str) -> None:
        super().__init__(text)
        self.detail = detail


class InterruptedCommand(click.Abort):
    """The user pressed Ctrl-C while a command ran. `detail` says whether the command was canceled
    or still runs."""

    def __init__(self, detail: Detail, text: str) -> None:
        super().__init__(text)
        self.detail = detail


_NO_ACCESS = (Detail.DENIED, Detail.REFUSED)


def exit_code(error: BaseException) -> ExitCode:
    """Returns the exit code for a failure of a command."""
    if isinstance(error, KeyboardInterrupt | click.Abort):
        return ExitCode.INTERRUPTED
    if isinstance(error, LeaseRefused) or _details(error) & set(_NO_ACCESS):
        return ExitCode.NO_ACCESS
    if isinstance(error, CommandFailed | TimeoutError):
        return ExitCode.COMMAND_FAILED
    if isinstance(error, ConnectionError):
        return ExitCode.CONNECTION_FAILED
    if isinstance(error, click.ClickException | EncodeError | JsonError | UsageFailure):
        return ExitCode.USAGE
    return ExitCode.ENVIRONMENT


def failure_json(error: BaseException) -> dict[str, Any]:
    """Returns a failure as `--json` shows it."""
    text = error.format_message() if isinstance(error, click.ClickException) else str(error)
    shown: dict[str, Any] = {"exit_code": int(exit_code(error)), "text": text or "interrupted"}
    details = _details(error)
    if details:
        detail = next((d for d in _NO_ACCESS if d in details), max(details))
        shown |= {"detail": detail.name, "state": detail.state.name}
    elif isinstance(error, LeaseRefused):
        shown |= {"detail": Detail.DENIED.name, "state": State.COMMAND_FAILED.name}
    since = _silent_since(error)
    if since is not None:
        shown["silent_since"] = since
    if isinstance(error, DeclaredError):
        shown["exception"] = error._gecos_name
    return {"error": shown}


def _silent_since(error: BaseException) -> float | None:
    attempts = error.attempts if isinstance(error, CreateError) else ()
    return next((a.silent_since for a in attempts if a.silent_since is not None), None)


def _details(error: BaseException) -> set[Detail]:
    if isinstance(error, CreateError):
        return {attempt.detail for attempt in error.attempts}
    if isinstance(error, CommandFailed | ConnectionFailed | NotEnded | InterruptedCommand):
        return {error.detail}
    return set()
