"""The views of `<file>.py`: interfaces, their tables, proxies and servants."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FunctionView:
    """A reader or writer of a body, as a function of the module."""

    head: str  # "def _device_mount_arguments(source: _Decoder) -> tuple[str, Frame]:"
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MethodTableView:
    """The constant that says how an operation is called."""

    name: str  # "_DEVICE_MOUNT"
    type: str  # "_Method[None, None]"
    operation: tuple[str, ...]  # arguments of _Operation(...)
    arguments: tuple[str, ...]  # what follows it


@dataclass(frozen=True, slots=True)
class StreamTableView:
    name: str
    arguments: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ProxyMemberView:
    is_stream: bool
    head: str
    doc: tuple[str, ...]
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HandlerView:
    code: str
    table: str
    method: str
    arguments: str
    result: str
    head: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PublisherView:
    head: str
    doc: str
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    servant: str
    constant: str  # "_DEVICE"
    scoped_name: str
    version: str
    hash: str
    doc: tuple[str, ...]
    client_bases: str  # "(Device)"
    server_bases: str
    base_proxies: tuple[str, ...]  # classes whose operations it inherits
    base_servants: tuple[str, ...]
    bases: tuple[str, ...]
    quality: str
    hidden: tuple[str, ...]  # by members; hints in its classes say `_list_`
    functions: tuple[FunctionView, ...]
    methods: tuple[MethodTableView, ...]
    streams: tuple[StreamTableView, ...]
    members: tuple[ProxyMemberView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]


@dataclass(frozen=True, slots=True)
class InterfacesView:
    source: str
    doc: tuple[str, ...]
    standard: tuple[str, ...]  # import lines of the standard library
    imports: tuple[str, ...]
    numpy: bool
    exported: tuple[str, ...]
    interfaces: tuple[InterfaceView, ...]
