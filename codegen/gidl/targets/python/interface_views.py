"""The views of `<file>.py`: interfaces, their tables, proxies and servants."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MethodTableView:
    """The constant that describes an operation's parameters, results and exceptions."""

    name: str  # name of the constant, for example "_DEVICE_MOUNT"
    result: str
    feedback: str
    operation: str  # "_Operation(…)"
    terms: tuple[str, ...]  # arguments after the operation: "takes=…", "gives=…"


@dataclass(frozen=True, slots=True)
class ParameterView:
    name: str
    hint: str
    default: str  # "" for a parameter without default


@dataclass(frozen=True, slots=True)
class ProxyMemberView:
    is_stream: bool
    name: str
    parameters: tuple[ParameterView, ...]
    result: str
    feedback: str  # "None" for an operation without feedback
    doc: tuple[str, ...]
    table: str


@dataclass(frozen=True, slots=True)
class HandlerView:
    name: str
    parameters: tuple[ParameterView, ...]
    result: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PublisherView:
    name: str  # name of the method, for example "publish_tool"
    doc: str
    hint: str
    stamp: str
    code: str
    table: str
    lends: str  # name of the method that lends the memory of the next sample; "" if there is none


@dataclass(frozen=True, slots=True)
class InwardView:
    """An inward stream: the constant that describes it, and the property by which the proxy writes
    it and the servant reads it."""

    constant: str
    name: str
    result: str  # type hint of the samples, for use outside of classes
    hint: str  # type hint of the samples, for use inside a class
    table: str  # "_inward(…)"
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EventView:
    """An event: its constant, and the property of the proxy."""

    constant: str
    name: str
    result: str  # type hint of the parameters, for use outside of classes
    hint: str  # type hint of the parameters, for use inside a class
    table: str  # "_event(…)"
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    servant: str
    constant: str  # name of the interface's constant, for example "_DEVICE"
    scoped_name: str
    version: str
    hash: str
    doc: tuple[str, ...]
    client_bases: tuple[str, ...]  # base classes of the proxy
    server_bases: tuple[str, ...]
    base_proxies: tuple[str, ...]  # proxies of the direct bases
    quality: str  # "" if the interface demands no quality
    model: str  # JSON that the object serves; "" for the built-in operations
    model_constant: str
    hidden: tuple[str, ...]  # builtin types whose names are also names of methods of the class
    methods: tuple[MethodTableView, ...]
    members: tuple[ProxyMemberView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]
    inward: tuple[InwardView, ...]
    events: tuple[EventView, ...]


@dataclass(frozen=True, slots=True)
class InterfacesView:
    source: str
    doc: tuple[str, ...]
    standard: tuple[str, ...]  # import lines of the standard library
    imports: tuple[str, ...]
    numpy: bool
    exported: tuple[str, ...]
    hidden: tuple[str, ...]  # builtin types that get an alias in the file, such as `_list_`
    interfaces: tuple[InterfaceView, ...]
