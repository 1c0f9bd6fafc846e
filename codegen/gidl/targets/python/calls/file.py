"""What the template of `<file>.py` prints of one file."""

from __future__ import annotations

import re

from gidl.file_names import python_module
from gidl.model import File, Interface
from gidl.targets.calls import refuse_unsupported
from gidl.targets.groups import group
from gidl.targets.python import names
from gidl.targets.python.calls.bases import class_bases
from gidl.targets.python.calls.facts import classes_of
from gidl.targets.python.calls.members import Members
from gidl.targets.python.calls.tables import Tables, quality
from gidl.targets.python.calls.views import (
    InterfacesView,
    InterfaceView,
)
from gidl.targets.python.homes import ModuleNames
from gidl.targets.python.imports import export_order, import_lines, private
from gidl.targets.python.lower import Lowering
from gidl.targets.python.values.names import type_doc


def interfaces_view(lowering: Lowering, file: File, types: tuple[str, ...]) -> InterfacesView:
    constants = names.Constants()
    interfaces = [d for d in file.declarations if isinstance(d, Interface)]
    lowering = _in_module(lowering, file, interfaces)
    views = tuple(_Interface(lowering, interface, constants).view() for interface in interfaces)
    text = "\n".join(_all_text(view) for view in views)
    doc = tuple(line for view in views[:1] for line in view.doc)
    modules = lowering.module.imports()
    if types:
        modules[f"{python_module(file.path)}_types"] = set(types)
    for module, words in _RUNTIME:
        used = private(word for word in words if _uses(text, f"_{word}"))
        modules.setdefault(module, set()).update(used)
    standard = {
        "abc": private(["abstractmethod"] if "def " in text else []),
        "collections.abc": private(["Mapping"]),
        "typing": private(["ClassVar", *(["TYPE_CHECKING"] if "_npt." in text else [])]),
    }
    given = [*types, *(name for view in views for name in (view.name, view.servant))]
    return InterfacesView(
        file.path,
        doc or (f"Types of {file.path}.",),
        tuple(import_lines(standard)) if views else (),
        tuple(import_lines(modules)),
        "_npt." in text,
        tuple(sorted(given, key=export_order)),
        views,
    )


def _in_module(lowering: Lowering, file: File, interfaces: list[Interface]) -> Lowering:
    """What prints for the interfaces of a file, whose module also gives the types of the file."""
    homes = lowering.module.homes
    used = {home for interface in interfaces for home in classes_of(lowering, interface)}
    own = python_module(file.path)
    return lowering.within(ModuleNames(homes, used, homes.names_of(file), [own, f"{own}_types"]))


def _all_text(view: InterfaceView) -> str:
    """Everything that the template prints of it, for finding out which names are used."""
    parts: list[str] = [view.client_bases, view.server_bases, view.quality, "_Handler"]
    for function in view.functions:
        parts += [function.head, *function.body]
    for method in view.methods:
        parts += [method.type, "_Operation(", *method.operation, *method.arguments]
    for stream in view.streams:
        parts += ["_OutwardStream(", *stream.arguments]
    for member in view.members:
        parts += [member.head, *member.body]
    for handler in view.handlers:
        parts += [handler.head, handler.arguments, handler.result]
    for publisher in view.publishers:
        parts += [publisher.head, *publisher.body]
    return "\n".join([*parts, "_Interface("])


def _uses(text: str, word: str) -> bool:
    return re.search(rf"\b{word}\b", text) is not None


_RUNTIME = (
    ("gecos", ("wire",)),
    ("gecos.command", ("Command",)),
    ("gecos.execution", ("Execution",)),
    (
        "gecos.interface",
        (
            "Access", "Handler", "Interface", "Kind", "Media", "Method", "OnLoss", "OnNew",
            "Operation", "OutwardStream", "Quality", "QualityClass", "no_arguments", "no_result",
            "nothing",
        ),
    ),
    ("gecos.proxy", ("Object", "StreamAttribute")),
    ("gecos.servant", ("Servant",)),
    ("gecos.wire", ("Decoder", "Parts")),
)  # fmt: skip


class _Interface(Tables, Members):
    def view(self) -> InterfaceView:
        interface = self.interface
        refuse_unsupported(interface)
        methods, members, handlers = [], [], []
        for call in self._layout.interfaces[interface.name].calls:
            methods.append(self._table(call))
            members.append(self._proxy_member(call))
            handlers.append(self._handler(call))
        streamed = [a for a in interface.attributes if a.streams_out]
        publishers = tuple(self._publisher(a) for a in streamed)
        bases = [self._module.proxy(base) for base in interface.bases]
        servants = [self._module.servant(base) for base in interface.bases]
        derived_from = class_bases(self._model, interface)
        return InterfaceView(
            self._name,
            self._layout.python_names.servants[interface.name].name,
            self.constants.name(self._name),
            interface.name,
            interface.facts.version or "",
            f"0x{self._layout.interfaces[interface.name].hash:016X}",
            type_doc(interface.facts),
            group([self._module.proxy(base) for base in derived_from] or ["_Object"]),
            group([self._module.servant(base) for base in derived_from] or ["_Servant"]),
            tuple(bases),
            tuple(servants),
            interface.all_bases,
            quality(interface.qos),
            tuple(sorted(self.hidden)),
            tuple(self._functions),
            tuple(methods),
            tuple(self._stream_table(a) for a in streamed),
            tuple(members),
            tuple(handlers),
            publishers,
        )
