"""What the templates of clients and servers print of one file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gidl.file_names import source_stem
from gidl.model import (
    Attribute,
    File,
    Interface,
    Model,
)
from gidl.targets.calls import (
    refuse_unsupported,
    short_name,
    stream_attributes,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.calls.client import Client
from gidl.targets.cpp.calls.facts import hex32, hex64
from gidl.targets.cpp.calls.server import ServerSide, fail
from gidl.targets.cpp.calls.tables import Tables, quality
from gidl.targets.cpp.calls.views import (
    CaseView,
    HandlerView,
    InterfacesNamespace,
    InterfacesView,
    InterfaceView,
    MethodView,
)
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.includes import system_headers
from gidl.targets.cpp.lower import Lowering
from gidl.wire_layout import CallKind


def interfaces_view(lowering: Lowering, file: File) -> InterfacesView:
    model = lowering.model
    stem = source_stem(file.path)
    others = [path for path in file.includes if _has_interface(model, path)]
    spaces: list[InterfacesNamespace] = []
    for declaration in file.declarations:
        if not isinstance(declaration, Interface):
            continue
        scope = "::".join(lowering.layout.cpp_names.types[declaration.name].scope)
        view = _Interface(lowering, declaration).view()
        if spaces and spaces[-1].name == scope:
            spaces[-1] = replace(spaces[-1], interfaces=(*spaces[-1].interfaces, view))
        else:
            spaces.append(InterfacesNamespace(scope, (view,)))
    views = [view for space in spaces for view in space.interfaces]
    return InterfacesView(
        file.path,
        f"{stem}_types.hpp",
        f"{stem}_client.hpp",
        f"{stem}_server.hpp",
        tuple(sorted({"memory"} | system_headers(t for v in views for t in _client_text(v)))),
        tuple(sorted({"cstdint"} | system_headers(t for v in views for t in _server_text(v)))),
        tuple(sorted(f"{source_stem(path)}_client.hpp" for path in others)),
        tuple(sorted(f"{source_stem(path)}_server.hpp" for path in others)),
        tuple(spaces),
    )


def _has_interface(model: Model, path: str) -> bool:
    return any(file.path == path and file.has_interface for file in model.files)


def _client_text(view: InterfaceView) -> Iterator[str]:
    for method in view.methods:
        yield f"{method.returns} {method.declared}"


def _server_text(view: InterfaceView) -> Iterator[str]:
    for handler in view.handlers:
        yield f"{handler.returns} {handler.parameters}"
    for publisher in view.publishers:
        yield publisher.parameter


class _Interface(Tables, Client, ServerSide):
    def view(self) -> InterfaceView:
        interface = self._interface
        refuse_unsupported(interface)
        streams = stream_attributes(self._model, self._layout, interface)
        methods: list[MethodView] = []
        handlers: list[HandlerView] = []
        for call in self._layout.interfaces[interface.name].calls:
            methods.append(self._method(call))
            handlers.append(self._handler(call))
            member = self._member(call)
            if (
                call.kind is CallKind.GETTER
                and isinstance(member, Attribute)
                and member.streams_out
            ):
                methods.append(self._subscribing(member, streams.index(member)))
        own = [s for s in streams if s.interface == interface.name]
        table = self._layout.cpp_names
        bases = [names.absolute(table.types[base]) for base in interface.bases]
        servants = [names.absolute(table.servants[base]) for base in interface.bases]
        return InterfaceView(
            table.types[interface.name].name,
            self._type,
            table.servants[interface.name].name,
            interface.name,
            doc_lines(interface.facts),
            interface.facts.version or "",
            hex64(self._layout.interfaces[interface.name].hash),
            ", ".join(f"public virtual {base}" for base in bases or ["gecos::Object"]),
            ", ".join(f"public virtual {base}" for base in servants or ["gecos::Servant"]),
            interface.all_bases,
            tuple(self._row(call) for call in self._calls),
            tuple(self._stream_row(attribute) for attribute in streams),
            quality(interface.qos),
            tuple(methods),
            tuple(handlers),
            tuple(self._publisher(s, streams.index(s)) for s in own),
            tuple(
                CaseView(hex32(c.code), self._caller_name(c), short_name(c)) for c in self._calls
            ),
            fail("call", "UnknownOperation", f'"{interface.name} has no such operation"'),
        )
