"""The views of `<file>_interface`, `<file>_client` and `<file>_server.{hpp,cpp}`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Written = Literal["plain", "block", "here"]
"""How a value is encoded. For "plain" and "block", a function of the runtime encodes the value:
"block" puts the length of the encoding before it. For "here", generated statements encode the
value."""


@dataclass(frozen=True, slots=True)
class OperationRow:
    """A row in the session's table of operations."""

    constant: str  # name of the operation's constant in the description class
    code: str
    name: str
    hash: str
    getter: bool  # True: `terms` are differences from the defaults of a getter
    terms: tuple[str, ...]  # ".cancelable = true": what differs from the defaults


@dataclass(frozen=True, slots=True)
class StreamRow:
    constant: str
    code: str
    name: str
    terms: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InwardRow:
    constant: str
    code: str
    name: str
    hash: str
    terms: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DescriptionView:
    """The class that describes an interface: its operations, streams and quality."""

    name: str  # "GripperInterface"
    bases: tuple[str, ...]  # scoped names of all direct and indirect bases
    inherits: tuple[str, ...]  # description classes of the direct bases
    operations: tuple[OperationRow, ...]  # own operations, sorted by function code
    streams: tuple[StreamRow, ...]
    inward_streams: tuple[InwardRow, ...]
    quality: str  # "" if the interface demands no quality
    model: str  # JSON that the object serves; "" for the built-in operations


@dataclass(frozen=True, slots=True)
class WritingView:
    """A lambda that encodes values, and the number of bytes that it writes."""

    sizing: tuple[str, ...]  # statements that prepare `size`
    size: str  # expression for the number of bytes
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
    declared: str  # parameter list with defaults, in parentheses
    defined: str  # parameter list without defaults, in parentheses
    checks: tuple[str, ...]  # statements that return an error if a parameter must not be sent
    does: str  # function that makes the call: "gecos_call<double>"
    constant: str  # constant that describes the operation: "GripperInterface::max_width"
    arguments: WritingView | None
    result: ReadingView | None


@dataclass(frozen=True, slots=True)
class WriterView:
    """A method of a client proxy that opens an inward stream."""

    doc: tuple[str, ...]
    name: str
    value: str  # type of the samples
    constant: str  # constant that describes the stream: "GripperInterface::jaws_stream"
    checks: tuple[str, ...]  # statements that return an error if a value must not be sent
    writing: WritingView


@dataclass(frozen=True, slots=True)
class InwardView:
    """The view of an inward stream in the servant, which reads the samples."""

    doc: tuple[str, ...]
    name: str
    member: str  # data member of the skeleton
    value: str  # type of the samples
    constant: str
    reading: ReadingView


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
    """A handler, which the author of a server implements, and the generated code that calls the
    handler."""

    doc: tuple[str, ...]
    returns: str
    name: str
    parameters: str  # parameter list in parentheses
    code: str
    operation: str  # name without scope: "move", "tool=" for a setter
    arguments: tuple[ArgumentView, ...]
    source: str  # name of the decoder from which the arguments are read
    was_read: str
    read: tuple[str, ...]  # lines of an expression that is true if all arguments were decoded
    execution: str  # type of the last parameter of a cancelable handler; "" for others
    run: str
    passed: str  # arguments of the handler: "(a, b, run)"
    declared: str  # exceptions that the handler may raise: '{"robcl::WidthOutOfRange"}'
    result: ResultView | None
    whole_name: str  # scoped name: "robcl::Gripper::open"


@dataclass(frozen=True, slots=True)
class LendingView:
    """A method of the skeleton that lends the memory of a stream's next sample."""

    name: str
    member: str  # the member of which the octets are written in place
    most: str  # bound of its elements


@dataclass(frozen=True, slots=True)
class PublisherView:
    name: str
    doc: str
    whole_name: str
    written: Written
    parameter: str  # type and name: "const T& value"
    constant: str  # constant that describes the stream: "GripperInterface::jaws_stream"
    checks: tuple[str, ...]
    writing: WritingView
    lending: LendingView | None  # None: samples are not written in place


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    servant: str
    scoped_name: str
    doc: tuple[str, ...]
    version: str
    hash: str
    description: DescriptionView
    client_bases: str
    server_bases: str
    servant_bases: tuple[str, ...]  # absolute names of the base servants
    request: str  # the skeleton's variable for an incoming call; no parameter has its name
    methods: tuple[MethodView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]
    writers: tuple[WriterView, ...]
    inward: tuple[InwardView, ...]

    @property
    def answers_else(self) -> str:
        """A C++ expression that asks each base servant to answer the call. The expression is true
        if a base servant has answered."""
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
    interface_includes: tuple[str, ...]
    client_includes: tuple[str, ...]
    server_includes: tuple[str, ...]
    namespaces: tuple[InterfacesNamespace, ...]
