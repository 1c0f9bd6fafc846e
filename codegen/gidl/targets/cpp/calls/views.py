"""The views of `<file>_client.{hpp,cpp}` and `<file>_server.{hpp,cpp}`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OperationRow:
    """A line of the table that the session reads."""

    code: str
    name: str
    kind: str
    status: str
    safety: str
    presence: str
    idempotent: str
    cancelable: str
    parallel: str
    ordered: str
    on_new: str
    on_loss: str
    quality: str
    hash: str


@dataclass(frozen=True, slots=True)
class StreamRow:
    code: str
    name: str
    status: str
    rate: str
    largest: str
    quality: str


@dataclass(frozen=True, slots=True)
class MethodView:
    """A method of a client proxy."""

    doc: tuple[str, ...]
    returns: str
    name: str
    declared: str  # "(parameters with defaults)"
    defined: str  # "(parameters without)"
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HandlerView:
    """What the implementer of a server writes, and the function that calls it."""

    doc: tuple[str, ...]
    returns: str
    name: str
    parameters: str  # "(…)"
    caller: str  # "gecos_call_move"
    request: str  # name of its parameter
    code: str
    operation: str  # "robcl::Manipulator::move"
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PublisherView:
    name: str
    stream: str  # its IDL name
    parameter: str  # "const T& value"
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class CaseView:
    code: str
    caller: str
    name: str


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    type: str  # the same, absolutely
    servant: str
    scoped_name: str
    doc: tuple[str, ...]
    version: str
    hash: str
    client_bases: str
    server_bases: str
    bases: tuple[str, ...]  # scoped names of every interface it also is
    operations: tuple[OperationRow, ...]
    streams: tuple[StreamRow, ...]
    quality: str
    methods: tuple[MethodView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]
    cases: tuple[CaseView, ...]  # inherited ones too, by code
    unknown: str  # answers another code


@dataclass(frozen=True, slots=True)
class InterfacesNamespace:
    name: str
    interfaces: tuple[InterfaceView, ...]


@dataclass(frozen=True, slots=True)
class InterfacesView:
    source: str
    types_header: str
    client_header: str
    server_header: str
    client_system: tuple[str, ...]
    server_system: tuple[str, ...]
    client_includes: tuple[str, ...]
    server_includes: tuple[str, ...]
    namespaces: tuple[InterfacesNamespace, ...]
