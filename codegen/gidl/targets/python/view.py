"""Lists the Python files to generate for a model, each with its template and view."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.files.names import python_stem
from gidl.model import Model
from gidl.targets.naming import OutputFile, has_output
from gidl.targets.python.homes import AllNames, Homes
from gidl.targets.python.interface_file import interfaces_view
from gidl.targets.python.layout_steps import Lowering
from gidl.targets.python.types_file import types_view
from gidl.wire.wire_layout import Layout


def lowering(model: Model, layout: Layout) -> Lowering:
    return Lowering(model, layout, AllNames(Homes(model, layout)))


def files(model: Model, layout: Layout) -> Iterator[OutputFile]:
    printing = lowering(model, layout)
    packages: set[str] = set()
    for file in model.files:
        if not (file.asked_for and has_output(model, file.path)):
            continue
        stem = python_stem(file.path)
        packages.update(stem.split("/")[:-1][:1])
        types = types_view(printing, file)
        yield OutputFile(f"python/{stem}_types.py", "python", "types.py.j2", types)
        interfaces = interfaces_view(printing, file, types.exported)
        yield OutputFile(f"python/{stem}.py", "python", "interfaces.py.j2", interfaces)
    for package in sorted(packages):
        yield OutputFile(f"python/{package}/py.typed", "python", "py.typed.j2", package)
