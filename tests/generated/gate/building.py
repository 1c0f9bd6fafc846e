"""Output of sets of .gidl files, compiled: all Python in one folder for mypy, and a C++ program for
each set, under AddressSanitizer and UndefinedBehaviorSanitizer, warnings being errors."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cpp_side import Program
from gidl.compile import compile_files
from gidl.files.names import source_stem
from gidl.model import Model
from gidl.targets.emit import UnsupportedError, render
from gidl.wire import wire_layout
from gidl.wire.events import events_as_streams
from gidl.wire.wire_layout import Layout

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[2]
RUNTIME = TREE / "runtime" / "cpp"
GENERATED = TREE / "generated" / "cpp"
SUPPORT = (
    HERE / "driver.cpp",
    *(RUNTIME / "gecos" / f"{name}.cpp" for name in (
        "wire/check", "wire/decoder", "wire/decode_error", "wire/swap_copy", "wire/text",
        "wire/json", "loan", "servant", "command", "description", "base/log", "base/clock",
        "base/moment",
    )),
    RUNTIME / "robcl" / "frames" / "frame.cpp",
    *(GENERATED / f"{name}.cpp" for name in (
        "gecos/object_ref_types", "gecos/object_ref_json",
        "robcl/geometry_types", "robcl/geometry_json",
    )),
)  # fmt: skip
# Without the checks of every access that AddressSanitizer sees, too: they take a fifth of the time.
SANITIZERS = (
    "-fsanitize=address,undefined",
    "-fno-sanitize=null,alignment,object-size,pointer-overflow,vptr",
    "-fno-sanitize-recover=undefined",
)
FIRST = "first.hpp"  # precompiled
LIBRARY = "libsupport.so"
OURS = ("gecos/", "robcl/")


@dataclass(frozen=True)
class Set:
    """Files that are generated together."""

    name: str
    files: tuple[Path, ...]
    search: tuple[Path, ...]
    wide: bool = False
    defines: tuple[str, ...] = ()


@dataclass(frozen=True)
class Generated:
    set: Set
    model: Model
    layout: Layout
    stems: list[str]
    texts: Mapping[str, str]  # by path below the output folder


@dataclass
class Shelf:
    """An output folder that several sets share, and what stands there."""

    folder: Path
    sets: list[Generated] = field(default_factory=list)
    texts: dict[str, str] = field(default_factory=dict)

    def takes(self, made: Generated) -> bool:
        """Takes `made`, unless it has another file of a name that is taken here."""
        if any(self.texts.get(path, text) != text for path, text in made.texts.items()):
            return False
        self.sets.append(made)
        self.texts.update(made.texts)
        for path, text in made.texts.items():
            file = self.folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        return True


def shelved(made: Iterable[Generated], folder: Path) -> list[Shelf]:
    """The output of all sets, below `folder`. Files of different projects have equal names."""
    shelves: list[Shelf] = []
    for each in made:
        if not any(shelf.takes(each) for shelf in shelves):
            shelves.append(Shelf(folder / f"shelf{len(shelves)}"))
            assert shelves[-1].takes(each)
    return shelves


class Rejected(Exception):
    """gidl does not accept the set, or cannot generate it."""


def generate(given: Set) -> Generated:
    search = [*map(str, given.search), str(TREE / "idl")]
    told: dict[str, Any] = {"wide": given.wide, "defines": given.defines}
    first = compile_files([str(f) for f in given.files], search, **told)
    # Included files that are not of our library are generated, too.
    more = [f.path for f in first.model.files if not f.path.startswith(OURS) and not f.asked_for]
    found = [next((r / p for r in given.search if (r / p).exists()), Path(p)) for p in more]
    compiled = compile_files([str(f) for f in (*given.files, *found)], search, **told)
    if compiled.has_errors:
        errors = [f for f in compiled.findings if f.severity.value == "error"]
        raise Rejected("\n".join(f"{f.location}: {f.code} {f.message}" for f in errors))
    model = events_as_streams(compiled.model)
    layout = wire_layout.build(model)
    try:
        texts = render(model, layout)
    except UnsupportedError as error:
        raise Rejected(f"gen: {error}") from None
    broken = [e for p, text in texts.items() if p.endswith(".py") for e in _syntax_error(p, text)]
    if broken:
        raise Rejected("\n".join(broken))  # mypy would check no file after a syntax error
    stems = [source_stem(f.path) for f in model.files if f.asked_for]
    return Generated(given, model, layout, stems, texts)


def _syntax_error(path: str, text: str) -> list[str]:
    try:
        compile(text, path, "exec")
    except SyntaxError as error:
        return [f"{path}:{error.lineno}: {error.msg}: {error.text}"]
    return []


def compilers() -> tuple[str, str]:
    """What compiles and what links. clang takes half the time of g++, but its sanitizers are often
    not installed; then those of g++ will do, whose interface is the same."""
    if "CXX" in os.environ:
        return os.environ["CXX"], os.environ["CXX"]
    asked = subprocess.run([TREE / "tools/clang.sh"], capture_output=True, text=True)
    if asked.returncode == 0:
        clang = asked.stdout.strip()
        with TemporaryDirectory() as folder:
            source, program = Path(folder) / "probe.cpp", Path(folder) / "probe"
            source.write_text("int main(int count, char**) { return count + 1 == 2 ? 0 : 1; }\n")
            object_ = [clang, *SANITIZERS, "-c", source, "-o", f"{program}.o"]
            for linker in (clang, "c++"):
                link = [linker, *SANITIZERS, f"{program}.o", "-o", program]
                steps: tuple[list[Any], ...] = (object_, link, [program])
                if all(not subprocess.run(s, capture_output=True).returncode for s in steps):
                    return clang, linker
    return "c++", "c++"


class Compiler:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._command, self._linker = compilers()
        self._cache = ["ccache"] if shutil.which("ccache") else []
        warnings = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow"]
        if os.environ.get("GECOS_WERROR", "ON") == "ON":
            warnings.append("-Werror")
        self._flags = [
            "-std=c++20", "-O0", "-fPIC", *warnings, *SANITIZERS,
            f"-I{GENERATED}", f"-I{RUNTIME}", f"-I{HERE}",
            "-isystem", "/usr/include/eigen3",
        ]  # fmt: skip
        self._common: list[str] = []  # objects of the precompiled header
        self.refused_by_clang_alone: list[str] = []
        """Names of the sets whose programs g++ compiles and clang does not."""
        self._environment = {**os.environ, "CCACHE_SLOPPINESS": "pch_defines,time_macros"}

    def first(self) -> None:
        """What every program includes first."""
        common = (
            "driver.hpp",
            "gecos/wire/json_text.hpp",
            "gecos/wire/fields.hpp",
            "gecos/wire/check.hpp",
        )
        first = "".join(f'#include "{header}"\n' for header in common)
        (self.folder / FIRST).write_text(first, encoding="utf-8")
        header = [self._command, *self._flags, "-x", "c++-header", FIRST, "-o"]
        if "clang" not in self._command:
            self._run([*header, f"{FIRST}.gch"])
            return
        # Its templates are instantiated and its functions compiled once, not in every program.
        once = ["-fpch-instantiate-templates", "-fpch-codegen", "-Xclang", "-fno-pch-timestamp"]
        self._run([*header, f"{FIRST}.pch", *once])
        quiet = "-Wno-unused-command-line-argument"  # the folders of headers
        self._run([self._command, *self._flags, quiet, "-c", f"{FIRST}.pch", "-o", "first.o"])
        self._common = ["first.o"]

    def support(self) -> None:
        """The library of every program, from one source: the headers are read once."""
        text = "".join(f'#include "{source}"\n' for source in SUPPORT)
        (self.folder / "support.cpp").write_text(text, encoding="utf-8")
        compiled = [self._command, *self._flags, "-c", "support.cpp", "-o", "support.o"]
        self._run([*self._cache, *compiled])
        objects = [*self._common, "support.o"]
        self._run([self._linker, *SANITIZERS, "-shared", *objects, "-o", LIBRARY])

    def program(
        self, made: Generated, shelf: Path, supported: Future[None]
    ) -> tuple[Program, Path]:
        """Raises Rejected with what the compiler says."""
        program = Program(made.model, made.layout, shelf / "cpp", made.stems)
        name = made.set.name
        (self.folder / f"{name}.gate.cpp").write_text(program.source(), encoding="utf-8")
        where = f"-I{shelf.relative_to(self.folder)}/cpp"
        rest = [*self._flags, where, "-include", FIRST, "-c", f"{name}.gate.cpp", "-o", f"{name}.o"]
        try:
            self._run([*self._cache, self._command, *rest])
        except Rejected:  # clang 14 crashes on some valid programs, and refuses others
            if "clang" not in self._command:
                raise
            self._run([*self._cache, "c++", *rest])
            self.refused_by_clang_alone.append(name)
        supported.result()
        linked = [f"{name}.o", LIBRARY, "-Wl,-rpath,$ORIGIN", "-o", name]
        self._run([self._linker, *SANITIZERS, *linked])
        return program, self.folder / name

    def _run(self, command: list[str]) -> None:
        done = subprocess.run(
            command, cwd=self.folder, capture_output=True, text=True, env=self._environment
        )
        if done.returncode:
            raise Rejected(f"C++: {done.stderr[:6000]}")


def type_checked(folder: Path) -> str:
    """What mypy says of all generated Python; empty when it says nothing."""
    cache = folder.with_name(f"{folder.name}-cache")
    sources = [TREE / "runtime" / "python", TREE / "generated" / "python", folder / "python"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases",
         "--config-file", os.devnull, "--cache-dir", str(cache), str(folder / "python")],
        env={**os.environ, "MYPYPATH": os.pathsep.join(map(str, sources))},
        capture_output=True, text=True,
    )  # fmt: skip
    return "" if done.returncode == 0 else done.stdout + done.stderr
