"""The interfaces as they were: a folder, or the tree of a git commit."""

from __future__ import annotations

import io
import subprocess
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

_GIT = "git#"


class AgainstError(ValueError):
    """What was named cannot be read; the text says why and what to do."""


@dataclass(frozen=True, slots=True)
class Baseline:
    folder: Path  # where includes begin
    files: tuple[str, ...]
    label: str  # before the paths of its files when they are shown: "main:"


@contextmanager
def baseline(text: str, subfolder: str) -> Iterator[Baseline]:
    """`text` is a folder, or git#ref=main (and git#ref=v1.2,subdir=interfaces). The folder lives
    as long as the context. Raises AgainstError."""
    if not text.startswith(_GIT):
        folder = Path(text)
        if not folder.is_dir():
            raise AgainstError(f"{text} is no folder; git#ref=main names a commit")
        yield _found(folder, f"{folder.as_posix()}/")
        return
    terms = dict(_term(part) for part in text.removeprefix(_GIT).split(","))
    unknown = set(terms) - {"ref", "subdir"}
    if unknown or not terms.get("ref"):
        raise AgainstError(f"'{text}' is not understood; write git#ref=main")
    with TemporaryDirectory(prefix="gidl-") as place:
        subfolder = terms.get("subdir", subfolder)
        _extract(terms["ref"], subfolder, Path(place))
        yield _found(Path(place) / subfolder, f"{terms['ref']}:{subfolder}/")


def _term(text: str) -> tuple[str, str]:
    name, _, value = text.partition("=")
    return name.strip(), value.strip()


def _found(folder: Path, label: str) -> Baseline:
    files = tuple(sorted(p.as_posix() for p in folder.rglob("*.gidl")))
    if not files:
        raise AgainstError(f"there are no .gidl files in {label.rstrip('/')}")
    return Baseline(folder, files, label)


def _extract(ref: str, subfolder: str, into: Path) -> None:
    if ref.startswith("-"):
        raise AgainstError(f"'{ref}' is no name of a commit")
    command = ["git", "archive", "--format=tar", ref, "--", f"./{subfolder}"]
    try:
        run = subprocess.run(command, capture_output=True, check=False)
    except OSError as problem:
        raise AgainstError(f"git cannot be run: {problem.strerror}") from problem
    if run.returncode != 0:
        said = run.stderr.decode("utf-8", "replace").strip().splitlines()
        raise AgainstError(f"git has no {subfolder}/ in '{ref}': {said[-1] if said else 'no word'}")
    with tarfile.open(fileobj=io.BytesIO(run.stdout)) as archive:
        if hasattr(tarfile, "data_filter"):  # Debian 12's Python 3.11.2 is older than it
            archive.extractall(into, filter="data")
        else:
            archive.extractall(into)  # git made it: no absolute paths, nothing outside
