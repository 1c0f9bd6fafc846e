"""The views of `<file>_interface`, `<file>_client` and `<file>_server.{hpp,cpp}`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gidl.targets.cpp.values.views import StructView

Written = Literal["plain", "block", "here"]
"""How a value is written: by the library, appendable ones in a block, or by statements here."""


@dataclass(frozen=True, slots=True)
class OperationRow:
    """An operation as the session knows it."""

    constant: str  # its name in the class of the interface
    code: str
    name: str
    hash: str
    getter: bool  # the defaults are those of a readable attribute
    terms: tuple[str, ...]  # ".cancelable = true": what differs from the defaults


@dataclass(frozen=True, slots=True)
class StreamRow:
    constant: str
    code: str
    name: str
    terms: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DescriptionView:
    """The class of an interface's operations, and what it is in the session's words."""

    name: str  # "GripperInterface"
    bases: tuple[str, ...]  # scoped names of every interface it also is
    inherits: tuple[str, ...]  # classes of the direct bases
    operations: tuple[OperationRow, ...]  # own ones, by code
    streams: tuple[StreamRow, ...]
    quality: str  # "" where nothing was asked for


@dataclass(frozen=True, slots=True)
class WritingView:
    """A lambda that writes values, and how many bytes it writes."""

    sizing: tuple[str, ...]  # statements
    size: str  # expression
    to: str
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ReadingView:
    """A lambda that reads a value."""

    source: str
    value: str
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MethodView:
    """A method of a client proxy: a call, or the subscription of a stream."""

    doc: tuple[str, ...]
    returns: str
    name: str
    declared: str  # "(parameters with defaults)"
    defined: str  # "(parameters without)"
    checks: tuple[str, ...]  # statements that return when a parameter must not be sent
    does: str  # "gecos_call<double>"
    constant: str  # "GripperInterface::max_width"
    arguments: WritingView | None
    result: ReadingView | None


@dataclass(frozen=True, slots=True)
class ArgumentView:
    type: str
    name: str
    initial: str


@dataclass(frozen=True, slots=True)
class ResultView:
    written: Written
    value: str
    checks: tuple[str, ...]
    writing: WritingView


@dataclass(frozen=True, slots=True)
class HandlerView:
    """A handler that the implementer of a server writes, and the call of it."""

    doc: tuple[str, ...]
    returns: str
    name: str
    parameters: str  # "(…)"
    code: str
    operation: str  # "move", "tool="
    arguments: tuple[ArgumentView, ...]
    source: str  # name of what they are read from
    was_read: str
    read: tuple[str, ...]  # lines of an expression: whether all were read
    execution: str  # type of what a cancelable handler has besides; "" without
    run: str
    passed: str  # "(a, b, run)"
    declared: str  # '{"robcl::OutOfRange"}'
    result: ResultView | None
    whole_name: str  # "robcl::Gripper::open"


@dataclass(frozen=True, slots=True)
class PublisherView:
    name: str
    stream: str  # its IDL name
    whole_name: str
    written: Written
    parameter: str  # "const T& value"
    constant: str  # "GripperInterface::jaws_stream"
    checks: tuple[str, ...]
    writing: WritingView


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    servant: str
    scoped_name: str
    doc: tuple[str, ...]
    version: str
    hash: str
    description: DescriptionView
    structs: tuple[StructView, ...]  # of arguments and results that the session knows
    client_bases: str
    server_bases: str
    servant_bases: tuple[str, ...]  # absolute names
    request: str  # what the skeleton calls an incoming call: parameters have their own names
    methods: tuple[MethodView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]

    @property
    def answers_else(self) -> str:
        """Whether a base answers the operations that this interface inherits."""
        asked = (f"{base}::gecos_answer({self.request})" for base in self.servant_bases)
        return " || ".join(asked) or "false"


@dataclass(frozen=True, slots=True)
class InterfacesNamespace:
    name: str
    interfaces: tuple[InterfaceView, ...]


@dataclass(frozen=True, slots=True)
class InterfacesView:
    source: str
    types_header: str
    interface_header: str
    client_header: str
    server_header: str
    interface_system: tuple[str, ...]
    client_system: tuple[str, ...]
    server_system: tuple[str, ...]
    has_structs: bool
    interface_includes: tuple[str, ...]
    client_includes: tuple[str, ...]
    server_includes: tuple[str, ...]
    namespaces: tuple[InterfacesNamespace, ...]
