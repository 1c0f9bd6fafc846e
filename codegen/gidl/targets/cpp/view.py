"""Lists the C++ files to generate for a model, each with its template and view."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.files.names import source_stem
from gidl.model import Model
from gidl.targets.cpp.call_structs import calls_view
from gidl.targets.cpp.interface_files import has_stubs, interfaces_view
from gidl.targets.cpp.json_files import json_view
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.types_files import types_view
from gidl.targets.naming import OutputFile, has_output
from gidl.wire.wire_layout import Layout


def files(model: Model, layout: Layout) -> Iterator[OutputFile]:
    lowering = Lowering(model, layout)
    for file in model.files:
        if not (file.asked_for and has_output(model, file.path)):
            continue
        stem = source_stem(file.path)
        types = types_view(lowering, file)
        for suffix in ("hpp", "cpp"):
            yield OutputFile(f"cpp/{stem}_types.{suffix}", "cpp", f"types.{suffix}.j2", types)
        json = json_view(lowering, file)
        yield OutputFile(f"cpp/{stem}_json.hpp", "cpp", "json.hpp.j2", json)
        if json.shapes:
            yield OutputFile(f"cpp/{stem}_json.cpp", "cpp", "json.cpp.j2", json)
        if not file.has_interface:
            continue
        calls = calls_view(lowering, file)
        if calls.namespaces:
            yield OutputFile(f"cpp/{stem}_calls.hpp", "cpp", "calls.hpp.j2", calls)
        interfaces = interfaces_view(lowering, file)
        for part in ("interface", "client", "server") if has_stubs(file) else ("interface",):
            for suffix in ("hpp", "cpp"):
                path = f"cpp/{stem}_{part}.{suffix}"
                yield OutputFile(path, "cpp", f"{part}.{suffix}.j2", interfaces)
