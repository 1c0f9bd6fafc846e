"""Builds the view with which the template of a generated `<file>.py` is rendered."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gidl.files.names import python_module
from gidl.model import File, Interface
from gidl.targets.calls import refuse_unsupported
from gidl.targets.groups import flat
from gidl.targets.python import names
from gidl.targets.python.base_classes import class_bases
from gidl.targets.python.call_facts import classes_of
from gidl.targets.python.homes import ModuleNames
from gidl.targets.python.imports import export_order, import_lines, private
from gidl.targets.python.interface_members import Members
from gidl.targets.python.interface_tables import quality
from gidl.targets.python.interface_views import (
    HandlerView,
    InterfacesView,
    InterfaceView,
    ProxyMemberView,
)
from gidl.targets.python.layout_steps import Lowering
from gidl.targets.python.name_lookup import type_doc
from gidl.targets.served_model import served_model
from gidl.wire.wire_layout import CallKind


def interfaces_view(lowering: Lowering, file: File, types: tuple[str, ...]) -> InterfacesView:
    constants = names.Constants()
    interfaces = [d for d in file.declarations if isinstance(d, Interface)]
    lowering = _in_module(lowering, file, interfaces)
    views = tuple(_Interface(lowering, interface, constants).view() for interface in interfaces)
    text = "\n".join(flat(part) for view in views for part in _texts(view))
    doc = tuple(line for view in views[:1] for line in view.doc)
    modules = lowering.module.imports()
    if types:
        modules[f"{python_module(file.path)}_types"] = set(types)
    for module, words in _RUNTIME:
        used = private(word for word in words if _uses(text, f"_{word}"))
        modules.setdefault(module, set()).update(used)
    members = [member for view in views for member in view.members]
    if views:
        modules["gecos.interface"].update(private(["interface"]))
    if any(view.methods for view in views):
        modules["gecos.interface"].update(private(["Method", "method"]))
    if any(member.is_stream for member in members):
        modules["gecos.proxy"].update(private(["StreamAttribute"]))
    if any(publisher.lends for view in views for publisher in view.publishers):
        modules.setdefault("gecos.in_place", set()).update(private(["Loan"]))
    if any(view.inward for view in views):
        modules["gecos.interface"].update([*private(["inward"]), "Inward as _InwardTable"])
        modules.setdefault("gecos.writer", set()).update(private(["InwardAttribute"]))
        modules.setdefault("gecos.inward", set()).update(private(["Inward"]))
    if any(view.events for view in views):
        modules["gecos.interface"].update([*private(["event"]), "Event as _EventTable"])
        modules["gecos.proxy"].update(private(["Event"]))
    if any(not member.is_stream for member in members):
        modules["gecos.command"].update(private(["Command"]))
    standard = {
        "abc": private(["abstractmethod"] if any(view.handlers for view in views) else []),
        "typing": private(["TYPE_CHECKING"] if "_npt." in text else []),
    }
    given = [*types, *(name for view in views for name in (view.name, view.servant))]
    return InterfacesView(
        file.path,
        doc or (f"Types of {file.path}.",),
        tuple(import_lines(standard)) if views else (),
        tuple(import_lines(modules)),
        "_npt." in text,
        tuple(sorted(given, key=export_order)),
        tuple(sorted({name for view in views for name in view.hidden})),
        views,
    )


def _in_module(lowering: Lowering, file: File, interfaces: list[Interface]) -> Lowering:
    """Returns a copy of `lowering` that prints names as the generated module `<file>.py` uses them.
    The module `<file>.py` also exports the types of the file, so the copy treats these types as
    defined in the module."""
    homes = lowering.module.homes
    used = {home for interface in interfaces for home in classes_of(lowering, interface)}
    own = python_module(file.path)
    return lowering.within(ModuleNames(homes, used, homes.names_of(file), [own, f"{own}_types"]))


def _texts(view: InterfaceView) -> Iterator[str]:
    """Yields the texts in a view that may contain names of the gecos runtime."""
    yield from (*view.client_bases, *view.server_bases, view.quality)
    for method in view.methods:
        yield from (method.result, method.feedback, method.operation, *method.terms)
    heads: list[ProxyMemberView | HandlerView] = [*view.members, *view.handlers]
    for each in heads:
        parameters = each.parameters
        yield from (each.result, *(p.hint for p in parameters), *(p.default for p in parameters))
    yield from (publisher.hint for publisher in view.publishers)
    for inward in view.inward:
        yield from (inward.hint, inward.result, inward.table)
    for event in view.events:
        yield from (event.hint, event.result, event.table)


def _uses(text: str, word: str) -> bool:
    return re.search(rf"\b{word}\b", text) is not None


_RUNTIME = (
    ("gecos.command", ()),
    ("gecos.execution", ("Execution",)),
    (
        "gecos.interface",
        (
            "Access", "Kind", "Media", "OnDegraded", "OnLoss", "OnNew", "Operation", "Quality",
            "QualityClass", "Reliability", "getter", "values",
        ),
    ),
    ("gecos.proxy", ("Object",)),
    ("gecos.servant", ("Servant",)),
    ("gecos.wire", ("layout",)),
)  # fmt: skip


class _Interface(Members):
    def view(self) -> InterfaceView:
        interface = self.interface
        refuse_unsupported(interface)
        calls = self._layout.interfaces[interface.name].calls
        getters = {call.name: call for call in calls if call.kind is CallKind.GETTER}
        outward = [a for a in interface.attributes if a.streams_out]
        events = [a for a in outward if a.event is not None]
        streamed = [a for a in outward if a.event is None]
        derived_from = class_bases(self._model, interface)
        asked = quality(interface.qos)
        return InterfaceView(
            self._name,
            self._layout.python_names.servants[interface.name].name,
            self.constants.name(self._name),
            interface.name,
            interface.facts.version or "",
            f"0x{self._layout.interfaces[interface.name].hash:016X}",
            type_doc(interface.facts),
            tuple(self._module.proxy(base) for base in derived_from) or ("_Object",),
            tuple(self._module.servant(base) for base in derived_from) or ("_Servant",),
            tuple(self._module.proxy(base) for base in interface.bases),
            "" if asked == "_Quality()" else asked,
            served_model(self._model, self._layout, interface),
            self.constants.name(self._name, "served", "model"),
            methods=tuple(self._table(call) for call in calls),
            members=tuple(self._proxy_member(call) for call in calls),
            handlers=tuple(self._handler(call) for call in calls),
            publishers=(
                *(self._publisher(a, getters[a.scoped_name]) for a in streamed),
                *(self._event_publisher(a) for a in events),
            ),
            inward=tuple(self._inward(a) for a in interface.attributes if a.streams_in),
            events=tuple(self._event(a) for a in events),
            hidden=tuple(sorted(self.hidden)),
        )
