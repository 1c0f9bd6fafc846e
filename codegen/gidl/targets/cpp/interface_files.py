"""Builds the view with which the templates of clients and servers of a file are rendered."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from gidl.files.names import source_stem
from gidl.model import (
    BUILT_IN,
    Attribute,
    File,
    Interface,
    Model,
)
from gidl.targets.calls import (
    refuse_unsupported,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.call_facts import hex64
from gidl.targets.cpp.client_methods import Client
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.includes import system_headers
from gidl.targets.cpp.interface_tables import Tables, quality
from gidl.targets.cpp.interface_views import (
    DescriptionView,
    HandlerView,
    InterfacesNamespace,
    InterfacesView,
    InterfaceView,
    MethodView,
)
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.servant_handlers import ServerSide
from gidl.targets.served_model import served_model
from gidl.wire.wire_layout import CallKind


def interfaces_view(lowering: Lowering, file: File) -> InterfacesView:
    model = lowering.model
    stem = source_stem(file.path)
    others = [path for path in file.includes if _has(model, path, lambda each: each.has_interface)]
    stubs = [path for path in others if _has(model, path, has_stubs)]
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
        f"{stem}_interface.hpp",
        f"{stem}_client.hpp",
        f"{stem}_server.hpp",
        tuple(sorted(set().union(*(_interface_headers(view) for view in views)))),
        tuple(sorted({"memory"} | system_headers(t for v in views for t in _client_text(v)))),
        tuple(sorted({"cstdint"} | system_headers(t for v in views for t in _server_text(v)))),
        tuple(sorted(f"{source_stem(path)}_interface.hpp" for path in others)),
        tuple(sorted(f"{source_stem(path)}_client.hpp" for path in stubs)),
        tuple(sorted(f"{source_stem(path)}_server.hpp" for path in stubs)),
        tuple(spaces),
    )


def has_stubs(file: File) -> bool:
    """Returns whether proxies and skeletons are generated for a file. The file of the built-in
    operations has none, because the session itself calls and answers the built-in operations, with
    the help of their argument and result structs."""
    interfaces = [each.name for each in file.declarations if isinstance(each, Interface)]
    return any(name != BUILT_IN for name in interfaces)


def _has(model: Model, path: str, what: Callable[[File], bool]) -> bool:
    return any(file.path == path and what(file) for file in model.files)


def _interface_headers(view: InterfaceView) -> set[str]:
    return {"string_view"} if view.description.bases else set()


def _client_text(view: InterfaceView) -> Iterator[str]:
    for method in view.methods:
        yield f"{method.returns} {method.declared}"
    for writer in view.writers:
        yield writer.value


def _server_text(view: InterfaceView) -> Iterator[str]:
    for handler in view.handlers:
        yield f"{handler.returns} {handler.parameters}"
    for publisher in view.publishers:
        yield publisher.parameter
    for inward in view.inward:
        yield inward.value


class _Interface(Tables, Client, ServerSide):
    def view(self) -> InterfaceView:
        interface = self._interface
        refuse_unsupported(interface)
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
                methods.append(self._subscribing(member))
        methods += [self._subscribing(each) for each in interface.attributes if each.event]
        table = self._layout.cpp_names
        bases = [names.absolute(table.types[base]) for base in interface.bases]
        servants = tuple(names.absolute(table.servants[base]) for base in interface.bases)
        return InterfaceView(
            table.types[interface.name].name,
            table.servants[interface.name].name,
            interface.name,
            doc_lines(interface.facts),
            interface.facts.version or "",
            hex64(self._layout.interfaces[interface.name].hash),
            self._description(),
            ", ".join(f"public virtual {base}" for base in bases or ["gecos::Object"]),
            ", ".join(f"public virtual {base}" for base in servants or ["gecos::Servant"]),
            servants,
            self._request,
            tuple(methods),
            tuple(handlers),
            tuple(self._publisher(s) for s in self._own_streams()),
            tuple(self._writer(s) for s in self._own_inward_streams()),
            tuple(self._inward(s) for s in self._own_inward_streams()),
        )

    def _description(self) -> DescriptionView:
        interface = self._interface
        table = self._layout.cpp_names.descriptions
        return DescriptionView(
            table[interface.name].name,
            interface.all_bases,
            tuple(f"&{names.absolute(table[base])}::description" for base in interface.bases),
            tuple(self._row(call) for call in self._calls),
            tuple(self._stream_row(attribute) for attribute in self._own_streams()),
            tuple(self._inward_row(attribute) for attribute in self._own_inward_streams()),
            ", ".join(quality(interface.qos)),
            served_model(self._model, self._layout, interface),
        )
