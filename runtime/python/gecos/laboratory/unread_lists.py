"""Notices that lists of users were added to a `lab.toml` that the running programs do not read."""

from __future__ import annotations

from pathlib import Path

from gecos.laboratory.description import (
    LaboratoryDescription,
    LaboratoryFileError,
    read_laboratory,
)


class UnreadLists:
    """Watches the file of a laboratory if this file had no lists when the programs were started.
    The programs then do not read the file, so they ignore lists that are added later.

    `gecos up` gives the programs only a file with lists, for two reasons. A program reads this file
    in place of the lab file of the host, and would miss the lists and zones of the host's file.
    Servers also refuse a file that a group may write."""

    def __init__(self, laboratory: LaboratoryDescription) -> None:
        watched = bool(laboratory.file) and not laboratory.names_users
        self._file = Path(laboratory.file).resolve() if watched else None
        self._shown = laboratory.file
        # The first check reads the file again, because a user may have edited the file meanwhile.
        self._seen: tuple[int, int] | None = None

    def appeared(self) -> str:
        """Returns a message for the user once, when lists have appeared in the file; otherwise "".
        While the file has an error, its lists do not count."""
        if self._file is None or (state := self._state()) == self._seen:
            return ""
        self._seen = state
        try:
            if not read_laboratory(self._file).names_users:
                return ""
        except LaboratoryFileError:
            return ""
        self._file = None
        return (
            f"{self._shown} now has lists of users or objects. The running programs do not read "
            "these lists: the file had none when the programs were started. End `gecos up` and "
            "start it again"
        )

    def _state(self) -> tuple[int, int] | None:
        try:
            found = None if self._file is None else self._file.stat()
        except OSError:
            return None
        return None if found is None else (found.st_mtime_ns, found.st_size)
