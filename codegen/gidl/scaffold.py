"""`gidl new`: a device from nothing. The files are complete: they generate, build and run."""

from __future__ import annotations

import keyword
import re
import tempfile
from pathlib import Path
from string import Template

from gidl.compile import compile_files

_STARTING_POINT = Path(__file__).parent / "starting_point"
_FILES = {
    "device.gidl.tmpl": "lab/{name}.gidl",
    "server.py.tmpl": "server.py",
    "client.cpp.tmpl": "client.cpp",
    "CMakeLists.txt.tmpl": "CMakeLists.txt",
    "README.md.tmpl": "README.md",
}
_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*\Z")


class ScaffoldRefusal(Exception):
    """Nothing was written; the text says why."""


def write_device(wanted: str, into: Path | None) -> str:
    """Writes the files of a device called `wanted` and says what to do next."""
    name = wanted.lower().replace("-", "_")
    if not _NAME.match(name):
        raise ScaffoldRefusal(
            f"'{wanted}' is no name: write letters, digits and _, like thermometer"
        )
    folder = into if into is not None else Path(name)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ScaffoldRefusal(f"{folder} is there already; --into names another folder")
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
    interface = f"lab/{name}.gidl"
    if keyword.iskeyword(name) or not _is_accepted(name, texts[interface]):
        raise ScaffoldRefusal(f"'{name}' has a meaning already; call it something else")
    for path, text in texts.items():
        place = folder / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8", newline="\n")
    return (
        f"gidl: {folder}/ has an interface, a Python server and a C++ client\n"
        f"gidl: {folder}/README.md says how to run them"
    )


def _is_accepted(name: str, interface: str) -> bool:
    """Whether the interface has no finding: a name may be a word of IDL, or one of the template."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / f"{name}.gidl"
        place.write_text(interface, encoding="utf-8")
        return not compile_files([str(place)], [folder]).findings
