"""What the template of `<file>.py` prints of one file."""

from __future__ import annotations

import re

from gidl.file_names import python_module
from gidl.model import File, Interface
from gidl.targets.calls import (
    refuse_unsupported,
)
from gidl.targets.python import names
from gidl.targets.python.calls.members import Members
from gidl.targets.python.calls.tables import Tables, quality
from gidl.targets.python.calls.views import (
    InterfacesView,
    InterfaceView,
)
from gidl.targets.python.imports import export_order, import_lines, private
from gidl.targets.python.lower import Lowering
from gidl.targets.python.values.names import BUILTIN_FUNCTIONS, type_doc


def interfaces_view(lowering: Lowering, file: File, types: tuple[str, ...]) -> InterfacesView:
    constants = names.Constants()
    interfaces = [d for d in file.declarations if isinstance(d, Interface)]
    builders = [_Interface(lowering, interface, constants) for interface in interfaces]
    views = tuple(builder.view() for builder in builders)
    text = "\n".join(_all_text(view) for view in views)
    doc = tuple(line for view in views[:1] for line in view.doc)
    servants = [f"{view.name}Servant" for view in views]
    modules = _imports(lowering, file, builders)
    if types:
        modules[f"{python_module(file.path)}_types"] = set(types)
    for module, words in _RUNTIME:
        used = private(word for word in words if _uses(text, f"_{word}"))
        modules.setdefault(module, set()).update(used)
    standard = {
        "abc": private(["abstractmethod"] if "def " in text else []),
        "builtins": private(word for word in BUILTIN_FUNCTIONS if _uses(text, f"_{word}")),
        "collections.abc": private(["Mapping"]),
        "typing": private(["ClassVar", *(["TYPE_CHECKING"] if "_npt." in text else [])]),
    }
    return InterfacesView(
        file.path,
        doc or (f"Types of {file.path}.",),
        bool(views),
        tuple(import_lines(standard)) if views else (),
        tuple(import_lines(modules)),
        "_npt." in text,
        tuple(sorted([*types, *(view.name for view in views), *servants], key=export_order)),
        views,
    )


def _all_text(view: InterfaceView) -> str:
    """Everything that the template prints of it, for finding out which names are used."""
    parts: list[str] = [view.client_bases, view.server_bases, view.quality]
    for function in view.functions:
        parts += [function.head, *function.body]
    for method in view.methods:
        parts += [method.type, "_Operation(", *method.operation, *method.arguments]
    for stream in view.streams:
        parts += ["_OutwardStream(", *stream.arguments]
    for member in view.members:
        parts += [member.head, *member.body]
    for handler in view.handlers:
        parts += ["_Handler(", handler.head, handler.arguments, handler.result]
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


def _imports(lowering: Lowering, file: File, builders: list[_Interface]) -> dict[str, set[str]]:
    """Types and base classes that live in other generated modules."""
    model = lowering.model
    modules: dict[str, set[str]] = {}
    used = {name for each in builders for name in (*each.used_types, *each.interface.bases)}
    names.refuse_same_names(model, file, used)
    for builder in builders:
        for name in builder.used_types:
            if not model.has(name) and name != names.OBJECT_REF:
                continue  # what this file makes of several results
            module = names.types_module(model, name)
            if module != f"{python_module(file.path)}_types":
                modules.setdefault(module, set()).add(names.type_name(model, name))
        for base in builder.interface.bases:
            if model.file_of(base) != file.path:
                module = python_module(model.file_of(base))
                simple = names.type_name(model, base)
                modules.setdefault(module, set()).update((simple, f"{simple}Servant"))
    return modules


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
        bases = [names.type_name(self._model, base) for base in interface.bases]
        return InterfaceView(
            self._name,
            self.constants.name(self._name),
            interface.name,
            interface.facts.version or "",
            f"0x{self._layout.interfaces[interface.name].hash:016X}",
            type_doc(interface.facts),
            ", ".join(bases or ["_Object"]),
            ", ".join([f"{base}Servant" for base in bases] or ["_Servant"]),
            tuple(bases),
            tuple(f"{base}Servant" for base in bases),
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
