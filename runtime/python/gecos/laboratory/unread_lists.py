"""Notices that tables for programs were added to a `lab.toml` that the running programs do not
read."""

from __future__ import annotations

from pathlib import Path

from gecos.laboratory.description import (
    LaboratoryDescription,
    LaboratoryFileError,
    read_laboratory,
)


class UnreadLists:
    """Watches the file of a laboratory if this file had no tables for programs, such as [allow],
    when the programs were started. The programs then do not read the file, so they ignore such
    tables that are added later.

    If the file has no such tables, `gecos up` does not name it to the programs, for two reasons.
    The programs would read it in place of the lab file of the host, whose lists and zones would
    then have no effect. Servers would also refuse the file if a group may write it."""

    def __init__(self, laboratory: LaboratoryDescription) -> None:
        watched = bool(laboratory.file) and not laboratory.tables_for_programs
        self._file = Path(laboratory.file).resolve() if watched else None
        self._shown = laboratory.file
        # The first check reads the file again in any case, because a user may have edited the file
        # after `laboratory` was read from it.
        self._seen: tuple[int, int] | None = None

    def appeared(self) -> str:
        """Returns a message for the user at the first call after such tables were added to the
        file. All other calls return "". While the file has an error, its tables do not count."""
        if self._file is None or (state := self._state()) == self._seen:
            return ""
        self._seen = state
        try:
            tables = read_laboratory(self._file).tables_for_programs
        except LaboratoryFileError:
            return ""
        if not tables:
            return ""
        self._file = None
        named = ", ".join(f"[{table}]" for table in tables)
        return (
            f"{self._shown} now has {named}. The running programs do not read the file: it had no "
            "such table when the programs were started. End `gecos up` and start it again"
        )

    def _state(self) -> tuple[int, int] | None:
        try:
            found = None if self._file is None else self._file.stat()
        except OSError:
            return None
        return None if found is None else (found.st_mtime_ns, found.st_size)
