"""Finds, reads and parses files. Included files come first, and each file is read once."""

from __future__ import annotations

import os
import re
import sys
import unicodedata
from collections.abc import Iterable, Set
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path, PurePosixPath

from gidl.diagnostics.findings import Findings, Severity
from gidl.diagnostics.source import MAX_BYTES, Source, Span
from gidl.files.installed import installed_folders
from gidl.files.names import is_interface
from gidl.syntax.conditions import Macros
from gidl.syntax.lexer import lex
from gidl.syntax.parser import parse
from gidl.syntax.preprocess import preprocess
from gidl.syntax.tree import FileSyntax, Include

PACKAGED = Path(__file__).parents[1] / "include"
VOCABULARY = "gecos/annotations.gidl"
OBJECT_REF = "gecos/object_ref.gidl"  # the file that declares the type of `Object` values
COMMAND_LINE = "<-D>"  # the path, in findings, of constants that -D defines
_MAX_INCLUDE_DEPTH = 100
_C_HEADERS = frozenset((".h", ".hh", ".hpp", ".hxx"))
_NOT_UTF_8 = re.compile("[\udc80-\udcff]")  # bytes decoded by surrogateescape
_AS_LATIN_1 = {0xDC00 + byte: byte for byte in range(0x80, 0x100)}


@dataclass(slots=True)
class LoadedFile:
    source: Source
    tree: FileSyntax
    asked_for: bool
    includes: list[str] = field(default_factory=list)  # paths of directly included files
    visible: set[str] = field(default_factory=set)  # paths of this file and of all its includes
    macros: Macros = field(default_factory=dict)  # macros that a file gets by including this file
    # Paths of directly included files that are read after this file, because of an include cycle.
    cut: list[str] = field(default_factory=list)
    lacks_includes: bool = False  # True: a direct or indirect include was not found


@dataclass(slots=True)
class Loader:
    """Loads files and all files that they include. The loader searches for an included file first
    in `search` (the folders of -I), then in the folder of the including file, then among the gecos/
    files of gidl itself, and at last in installed packages."""

    findings: Findings
    search: tuple[Path, ...] = ()
    wide: bool = False  # True (--wide): wide strings and characters are read as strings
    files: dict[str, LoadedFile] = field(default_factory=dict)  # by path, included files first
    sources: dict[str, Source] = field(default_factory=dict)
    _installed: tuple[Path, ...] = ()
    _by_place: dict[Path, str] = field(default_factory=dict)
    _headers_of_c: set[Path] = field(default_factory=set)  # C headers that were reported
    _given: Macros = field(default_factory=dict)  # macros that -D defines
    _macros: Macros = field(default_factory=dict)
    _open: list[str] = field(default_factory=list)
    # Paths of files whose include guard, or #pragma once, keeps them from being read again.
    _protected: set[str] = field(default_factory=set)
    # Maps the path of a file F to the files included by F that the loader is still reading, because
    # these files in turn include F. An include guard makes such a cycle legal.
    _cut: dict[str, list[str]] = field(default_factory=dict)

    def check_search(self) -> None:
        """Reports search folders that cannot be read."""
        for folder in self.search:
            try:
                with os.scandir(folder):
                    pass
            except (OSError, ValueError) as problem:
                reason = getattr(problem, "strerror", None) or str(problem)
                self.findings.file_error(
                    "G0024",
                    folder.as_posix(),
                    f"this folder cannot be searched for included files: {reason}",
                    "-I takes a folder to search for included files",
                )

    def define(self, constants: Iterable[str]) -> None:
        """Defines macros for all files. Each text is "NAME=VALUE" or "NAME"; "NAME" means
        "NAME=1"."""
        text = ""
        for constant in constants:
            name, equals, value = constant.partition("=")
            text += f"#define {name} {value if equals else 1}\n"
        source = Source(COMMAND_LINE, COMMAND_LINE, text)
        self.sources[COMMAND_LINE] = source
        preprocess(lex(source, self.findings), self.findings, self._given, lambda _include: None)

    def load_all(self, paths: Iterable[str]) -> None:
        for shown in paths:
            self._macros = dict(self._given)
            if shown == "-":
                data = _read_stdin(self.findings)
                if data is not None:
                    self._parse("stdin.gidl", _source("stdin.gidl", "-", data), asked_for=True)
                continue
            self._load(Path(shown), self._include_path(Path(shown)), shown, asked_for=True)

    def load_vocabulary(self) -> FileSyntax:
        """Parses the file that declares gidl's own annotations. The file does not become one of
        `files`."""
        place = PACKAGED / VOCABULARY
        source = Source(VOCABULARY, VOCABULARY, place.read_text(encoding="utf-8"))
        self.sources.setdefault(VOCABULARY, source)
        return parse(source, self.findings, {}, lambda _include: None)

    def _include_path(self, place: Path, beside: tuple[str, str] | None = None) -> str:
        """Returns the path by which other files include the file `place`. The path is relative to
        the search folder that contains the file. If no search folder contains the file, the path is
        relative to the folder of the including file. `beside` is a pair: the path of the including
        file, and the path that the `#include` in this file names."""
        whole = absolute(place)
        # The search folders of -I are tried last. One of them may contain an installed package, but
        # the path of a file in a package must be relative to the folder of the package.
        for folder in (*self._installed, PACKAGED, *self.search):
            if whole.is_relative_to(absolute(folder)):
                return whole.relative_to(absolute(folder)).as_posix()
        if beside is not None:
            including, written = beside
            joined = PurePosixPath(including).parent / written
            if ".." not in joined.parts and not joined.is_absolute():
                return joined.as_posix()
        return place.name

    def _load(self, place: Path, path: str, shown: str, asked_for: bool) -> str | None:
        try:
            real = place.resolve()
        except (OSError, ValueError, RuntimeError):
            real = place
        known = self._by_place.get(real)
        if known is not None:
            if asked_for and known in self.files:
                self.files[known].asked_for = True
            return known
        if _not_text(shown):
            name = shown.encode("utf-8", "backslashreplace").decode()
            self.findings.file_error(
                "G0001", name, "the name of this file is not UTF-8", "rename the file"
            )
            return None
        odd = next((character for character in path if _not_printed(character)), None)
        if odd is not None:
            what = f"{odd!r}" if odd in '"\\' else f"the control character U+{ord(odd):04X}"
            name = "".join(
                c if c.isprintable() else c.encode("unicode_escape").decode() for c in shown
            )
            self.findings.file_error(
                "G0001",
                name,
                f"the name of this file has {what}, which generated code cannot contain",
                "rename the file or its folder",
            )
            return None
        data = _read(place, shown, self.findings)
        if data is None:
            return None
        while path in self.sources and path != VOCABULARY:
            path = f"{place.parent.name}/{path}" if "/" not in path else f"_/{path}"
        self._by_place[real] = path
        self._parse(path, _source(path, shown, data), asked_for)
        return path

    def _parse(self, path: str, source: Source, asked_for: bool) -> None:
        self.sources[path] = source
        self._open.append(path)
        includes: list[str] = []
        lacks_includes = False

        def on_include(include: Include) -> None:
            if include.protected:
                self._protected.add(path)
            nonlocal lacks_includes
            found = self._include(include, source)
            lacks_includes |= found is None and not self._is_open(include, source)
            if found is not None and found not in includes:
                includes.append(found)

        before = dict(self._macros)
        tree = parse(source, self.findings, self._macros, on_include, wide=self.wide)
        if tree.uses_object:
            on_include(Include(OBJECT_REF, True, Span(source, 0, 0)))
        self._open.pop()
        left = {k: v for k, v in self._macros.items() if before.get(k) is not v}
        cut = self._cut.pop(path, [])
        loaded = LoadedFile(source, tree, asked_for, includes, macros=left, cut=cut)
        included = [self.files[p] for p in includes if p in self.files]
        loaded.visible = {path}.union(*(file.visible for file in included))
        loaded.lacks_includes = lacks_includes or any(file.lacks_includes for file in included)
        self.files[path] = loaded

    def _include(self, include: Include, source: Source) -> str | None:
        place = self._find(include, source)
        if place is None and PurePosixPath(include.path).suffix in _C_HEADERS:
            self._is_c(include)
            return None
        if place is None:
            self._not_found(include, source)
            return None
        if place.resolve() in self._headers_of_c:
            return None
        path = self._include_path(place, beside=(source.path, include.path))
        known = self._by_place.get(place.resolve())
        if known is not None:
            if known in self._open and known in self._protected:
                self._cut.setdefault(source.path, []).append(known)
                return None
            if known in self._open:
                chain = " -> ".join([*self._open[self._open.index(known) :], known])
                self.findings.error(
                    "G0004",
                    include.span,
                    f"files include each other: {chain}",
                    "if neither file needs names of the other file, write #pragma once before the "
                    "includes",
                )
                return None
            if known in self.files:
                self._macros.update(self.files[known].macros)
            return known
        if len(self._open) >= _MAX_INCLUDE_DEPTH:
            self.findings.error(
                "G0013",
                include.span,
                f"includes are nested deeper than {_MAX_INCLUDE_DEPTH} levels",
            )
            return None
        if place.suffix in _C_HEADERS:
            return self._header(include, place, path)
        return self._load(place, path, _shown(place), asked_for=False)

    def _header(self, include: Include, place: Path, path: str) -> str | None:
        """Loads a header, which may contain IDL or preprocessor constants. If the header has
        errors, all of them are replaced by one finding: the header contains C code."""
        before, findings = set(self.files), len(self.findings.found)
        found = self._load(place, path, _shown(place), asked_for=False)
        if all(f.severity is not Severity.ERROR for f in self.findings.found[findings:]):
            return found
        self.findings.forget_after(findings)
        self._forget_files(self.files.keys() - before)
        self._headers_of_c.add(place.resolve())
        self._is_c(include)
        return None

    def _forget_files(self, paths: Set[str]) -> None:
        """Removes files from the result, so that the loader reads them again when another file
        includes them."""
        for path in paths:
            del self.files[path], self.sources[path]
        for place in [place for place, path in self._by_place.items() if path in paths]:
            del self._by_place[place]

    def _is_c(self, include: Include) -> None:
        self.findings.error(
            "G0216",
            include.span,
            f"'{include.path}' contains C declarations, which are not part of .gidl",
            "include the .gidl or .idl file that declares the types",
        )

    def _is_open(self, include: Include, source: Source) -> bool:
        """Returns whether the loader is still reading the included file. The names in that file are
        then not known yet."""
        place = self._find(include, source)
        return place is not None and self._by_place.get(place.resolve()) in self._open

    def _folders(self, include: Include, source: Source) -> list[Path]:
        beside = [] if include.angled or source.shown == "-" else [Path(source.shown).parent]
        return [*self.search, *beside, PACKAGED]

    def _find(self, include: Include, source: Source) -> Path | None:
        place = _first_file(self._folders(include, source), include.path)
        if place is None:
            self._installed = installed_folders()  # slow, so called only when needed
            place = _first_file(self._installed, include.path)
        return place

    def _not_found(self, include: Include, source: Source) -> None:
        folders = self._folders(include, source)
        wanted = PurePosixPath(include.path).stem
        names: dict[str, str] = {}
        for folder in folders[:-1]:
            for place in sorted(folder.glob("*")) + sorted(folder.glob("*/*")):
                if not is_interface(place.name) or place.is_dir():
                    continue
                names.setdefault(place.stem, place.relative_to(folder).as_posix())
        close = get_close_matches(wanted, list(names), n=1, cutoff=0.7)
        searched = ", ".join(_shown(f) + "/" for f in folders[:-1]) or "nowhere"
        self.findings.error(
            "G0003",
            include.span,
            f"there is no file '{include.path}'",
            f"did you mean '{names[close[0]]}'?" if close else "",
            f"looked in {searched}; -I adds a folder",
        )


def _first_file(folders: Iterable[Path], path: str) -> Path | None:
    for folder in folders:
        try:
            if (folder / path).is_file():
                return folder / path
        except (OSError, ValueError):
            continue
    return None


def read_text(shown: str, findings: Findings) -> str | None:
    """Returns the text of a file, or of stdin if `shown` is "-". If the text cannot be read or is
    not UTF-8, returns None and adds a finding."""
    data = _read_stdin(findings) if shown == "-" else _read(Path(shown), shown, findings)
    if data is None:
        return None
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        findings.file_error(
            "G0002",
            shown,
            f"this file is not UTF-8: byte {data[problem.start]:#04x} in line {line}",
        )
        return None


def _source(path: str, shown: str, data: bytes) -> Source:
    """Decodes `data` as UTF-8. Bytes that are not UTF-8 are read as Latin-1; the lexer reports them
    later."""
    text = data.decode("utf-8", "surrogateescape")
    foreign = tuple(m.start() for m in _NOT_UTF_8.finditer(text))
    return Source(path, shown, text.translate(_AS_LATIN_1), foreign)


def _read_stdin(findings: Findings) -> bytes | None:
    try:
        data = sys.stdin.buffer.read(MAX_BYTES + 1)
    except OSError as problem:
        findings.file_error("G0001", "-", f"stdin cannot be read: {problem.strerror}")
        return None
    return _checked(data, "-", findings)


def _read(place: Path, shown: str, findings: Findings) -> bytes | None:
    try:
        if place.is_dir():
            findings.file_error(
                "G0001",
                shown,
                "this path is a folder, not a file",
                f"name its files: {shown.rstrip('/')}/*.*idl",
            )
            return None
        if place.exists() and not place.is_file():
            findings.file_error(
                "G0001",
                shown,
                "this path is a pipe or device, not a regular file",
                "to read stdin, write - in place of the path",
            )
            return None
        with place.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        findings.file_error("G0001", shown, f"this file cannot be read: {reason}")
        return None
    return _checked(data, shown, findings)


def _not_text(name: str) -> bool:
    """Returns whether a file name is not UTF-8. Generated files cannot contain such a name."""
    return any("\udc80" <= character <= "\udcff" for character in name)


def _not_printed(character: str) -> bool:
    """Returns whether a character of a path would break a line such as `#include
    "lab/lamp_types.hpp"`."""
    return character in '"\\' or unicodedata.category(character) in ("Cc", "Zl", "Zp")


def _checked(data: bytes, shown: str, findings: Findings) -> bytes | None:
    if len(data) > MAX_BYTES:
        limit = MAX_BYTES // (1024 * 1024)
        findings.file_error("G0011", shown, f"this file is larger than {limit} MiB")
        return None
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        findings.file_error(
            "G0002", shown, f"this file is not text: it has a NUL byte in line {line}"
        )
        return None
    if b"\r" in data.strip() and b"\n" not in data:
        findings.file_error(
            "G0002",
            shown,
            "the lines of this file end with CR alone",
            "end lines with LF or CR LF; to convert: tr '\\r' '\\n' < FILE > NEW_FILE",
        )
        return None
    return data


def absolute(place: Path) -> Path:
    """Returns the absolute path without "..", so that different spellings of a folder compare
    equal."""
    return Path(os.path.abspath(place))  # noqa: PTH100 (resolve() follows links)


def _shown(place: Path) -> str:
    """Returns the path for messages: relative to the current folder if the file is below that
    folder."""
    try:
        return place.absolute().relative_to(Path.cwd()).as_posix()
    except (ValueError, OSError):
        return place.as_posix()


def default_search(paths: Iterable[str]) -> tuple[Path, ...]:
    """Returns the search folders to use without -I: for each file, the nearest enclosing folder
    named `idl`."""
    found: list[Path] = []
    for path in paths:
        for parent in Path(path).parents:
            if parent.name == "idl" and parent not in found:
                found.append(parent)
                break
    return tuple(found)
