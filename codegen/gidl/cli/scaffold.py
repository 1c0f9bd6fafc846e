"""Writes the files of `gidl new`: a new device, or a mock server. The files build and run without
changes."""

from __future__ import annotations

import keyword
import re
import tempfile
from pathlib import Path
from string import Template

from gidl.compile import Compiled, compile_files
from gidl.files.loader import absolute
from gidl.files.names import source_stem
from gidl.model import Interface
from gidl.wire import wire_layout
from gidl.wire.events import events_as_streams

_STARTING_POINT = Path(__file__).parent / "starting_point"
_FILES = {
    "device.gidl.tmpl": "idl/lab/{name}.gidl",
    "gidl.toml.tmpl": "gidl.toml",
    "server.py.tmpl": "server.py",
    "client.cpp.tmpl": "client.cpp",
    "CMakeLists.txt.tmpl": "CMakeLists.txt",
    "README.md.tmpl": "README.md",
}
_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*\Z")


class ScaffoldRefusal(Exception):
    """Raised before any file is written; the text says why the files cannot be written."""


def write_device(wanted: str, into: Path | None) -> str:
    """Writes the files of a device called `wanted`. Returns a text with the next steps."""
    name = wanted.lower().replace("-", "_")
    if not _NAME.match(name):
        raise ScaffoldRefusal(
            f"'{wanted}' is not a valid name: write letters, digits and _, for example thermometer"
        )
    folder = _new_folder(into if into is not None else Path(name))
    words = {
        "name": name,
        "Name": "".join(part.capitalize() for part in name.split("_")),
        "NAME": name.upper(),
        "words": name.replace("_", " "),
    }
    texts = {}
    for template, path in _FILES.items():
        pattern = Template((_STARTING_POINT / template).read_text(encoding="utf-8"))
        texts[path.format(name=name)] = pattern.substitute(words)
    interface = f"idl/lab/{name}.gidl"
    if keyword.iskeyword(name) or not _is_accepted(name, texts[interface]):
        raise ScaffoldRefusal(f"'{name}' is reserved or already declared; choose another name")
    _write(folder, texts)
    return (
        f"gidl: {folder}/ has an interface, a Python server and a C++ client\n"
        f"gidl: {folder}/README.md says how to run them"
    )


def write_mock(
    compiled: Compiled, language: str, wanted: str | None, into: Path | None, search: list[str]
) -> str:
    """Writes a mock server for the interfaces of the file, or only for the interface `wanted`.
    Returns a text with the next steps. Raises UnsupportedError if an interface uses something that
    gidl cannot generate."""
    from gidl.targets.emit import render, render_mock

    model = events_as_streams(compiled.model)
    (file,) = (f for f in model.files if f.asked_for)
    there = [d for d in file.declarations if isinstance(d, Interface)]
    chosen = [i for i in there if wanted in (None, i.name, i.simple_name)]
    if not chosen:
        known = ", ".join(i.name for i in there) or "none at all"
        asked = f"no interface {wanted}" if wanted else "no interface to mock"
        raise ScaffoldRefusal(f"{file.path} declares {asked}; there is {known}")
    layout = wire_layout.build(model)
    render(model, layout, [language])  # raises UnsupportedError before any file is written
    # Names of CMake targets cannot contain spaces.
    stem = re.sub(r"\W", "_", Path(source_stem(file.path)).name)
    folder = _new_folder(into if into is not None else Path(f"{stem}_mock"))
    source = "server.py" if language == "python" else "server.cpp"
    texts = {source: render_mock(model, layout, language, chosen)}
    place = absolute(Path(compiled.sources[file.path].shown))
    root = place.parents[len(Path(file.path).parts) - 1]
    if language == "cpp":
        words = {
            "stem": stem,
            "file": place.as_posix(),
            "root": root.as_posix(),
            "imports": "".join(f' "{absolute(Path(each)).as_posix()}"' for each in search),
        }
        pattern = Template((_STARTING_POINT / "mock.txt.tmpl").read_text(encoding="utf-8"))
        texts["CMakeLists.txt"] = pattern.substitute(words)
    _write(folder, texts)
    served = ", ".join(i.name for i in chosen)
    if language == "python":
        run = (
            f"gidl gen -I {root} --lang python --out generated {place}; "
            f"PYTHONPATH=generated/python python {folder}/{source}"
        )
    else:
        run = f"cmake -B build -S {folder} -Drobcl_DIR=<build folder of robcl>; build/server"
    return (
        f"gidl: {folder}/{source} is a mock server of {served}\n"
        f"gidl: start `gecos broker`, then run: {run}"
    )


def _new_folder(folder: Path) -> Path:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ScaffoldRefusal(f"{folder} exists already; choose another folder with --into")
    return folder


def _write(folder: Path, texts: dict[str, str]) -> None:
    for path, text in texts.items():
        place = folder / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8", newline="\n")


def _is_accepted(name: str, interface: str) -> bool:
    """Returns whether the text `interface` of a new file NAME.gidl compiles without a finding. A
    finding means that `name` is an IDL keyword, or that the template already declares this name."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / f"{name}.gidl"
        place.write_text(interface, encoding="utf-8")
        return not compile_files([str(place)], [folder]).findings
