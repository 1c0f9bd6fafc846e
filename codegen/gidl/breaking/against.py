"""Reads the older version of the interfaces from a folder or from a git commit. `gidl breaking`
compares the new interfaces with this version."""

from __future__ import annotations

import io
import os
import subprocess
import tarfile
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from gidl.files.names import interfaces_below, source_stem

_GIT = "git#"


class AgainstError(ValueError):
    """The old interfaces cannot be read; the text says why and what to do."""


@dataclass(frozen=True, slots=True)
class Root:
    """A folder of interfaces on disk, and its name in messages, for example "main:idl/"."""

    folder: Path
    label: str


@dataclass(frozen=True, slots=True)
class Baseline:
    roots: tuple[Root, ...]

    def files(self, wanted: Collection[str] | None) -> list[str]:
        """Returns the paths of the old interface files. With `wanted`, returns only the files whose
        stems (paths without suffix) are in `wanted`."""
        found: dict[str, str] = {}
        for root in self.roots:
            for place in interfaces_below(root.folder):
                found.setdefault(place.relative_to(root.folder).as_posix(), place.as_posix())
        return [
            place for path, place in found.items() if wanted is None or source_stem(path) in wanted
        ]

    def shown(self, place: str) -> str:
        for root in self.roots:
            if Path(place).is_relative_to(root.folder):
                return root.label + Path(place).relative_to(root.folder).as_posix()
        return place


@contextmanager
def baseline(text: str, roots: Sequence[Path]) -> Iterator[Baseline]:
    """Gives access to the old interfaces that `text` names. If `text` is the path of a folder, this
    folder is the old version of the first folder in `roots`. If `text` is `git#ref=main`, the old
    interfaces are those of the folders `roots` in the commit `main`; with
    `git#ref=v1.2,subdir=interfaces`, they are those of the folder `interfaces` in the commit
    `v1.2`. Files of a commit are copied to disk, and deleted when the context ends. Raises
    AgainstError."""
    if not text.startswith(_GIT):
        folder = Path(text)
        if not folder.is_dir():
            raise AgainstError(
                f"{text} is not a folder; to compare with a commit, write git#ref=main"
            )
        yield _filled((Root(folder, f"{folder.as_posix()}/".removeprefix("./")),))
        return
    terms = dict(_term(part) for part in text.removeprefix(_GIT).split(","))
    unknown = set(terms) - {"ref", "subdir"}
    if unknown or not terms.get("ref"):
        raise AgainstError(
            f"'{text}' is not in the form git#ref=COMMIT or git#ref=COMMIT,subdir=FOLDER"
        )
    ref = terms["ref"]
    if ref.startswith("-"):
        raise AgainstError(f"'{ref}' is no name of a commit")
    wanted = [Path(terms["subdir"])] if "subdir" in terms else roots
    with TemporaryDirectory(prefix="gidl-") as place:
        yield _filled(
            tuple(
                _extracted(ref, folder, Path(place) / str(number))
                for number, folder in enumerate(wanted)
            )
        )


def _term(text: str) -> tuple[str, str]:
    name, _, value = text.partition("=")
    return name.strip(), value.strip()


def _filled(roots: tuple[Root, ...]) -> Baseline:
    found = Baseline(roots)
    if not found.files(None):
        where = ", ".join(root.label.rstrip("/") for root in roots)
        raise AgainstError(f"there are no .gidl or .idl files in {where}")
    return found


def _extracted(ref: str, folder: Path, into: Path) -> Root:
    top = _git("rev-parse", "--show-toplevel").stdout.decode().strip()
    path = os.path.relpath(folder.resolve(), top or ".")
    tree = "" if path == "." else path
    run = _git("-C", top or ".", "archive", "--format=tar", f"{ref}:{tree}")
    if run.returncode != 0:
        said = run.stderr.decode("utf-8", "replace").strip().splitlines()
        reason = said[-1] if said else "no reason given"
        raise AgainstError(f"git has no {folder.as_posix()}/ in '{ref}': {reason}")
    with tarfile.open(fileobj=io.BytesIO(run.stdout)) as archive:
        if hasattr(tarfile, "data_filter"):  # data_filter is missing in Debian 12's Python 3.11.2
            archive.extractall(into, filter="data")
        else:
            archive.extractall(into)  # safe: paths in a git archive stay below `into`
    return Root(into, f"{ref}:{folder.as_posix()}/".replace(":./", ":"))


def _git(*words: str) -> subprocess.CompletedProcess[bytes]:
    try:
        return subprocess.run(["git", *words], capture_output=True, check=False)
    except OSError as problem:
        raise AgainstError(f"git cannot be run: {problem.strerror}") from problem
