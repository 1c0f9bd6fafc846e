"""Turns each event into a stream of its parameters. Media and sessions then handle events in the
same way as streams.

For example, the event `touched(in Pose where)` of the interface `Arm` becomes the stream `touched`,
whose samples are structs of the type `Arm::touched`. An event has no getter, so a
program can only subscribe to this stream. The struct is appendable, so parameters with defaults may
be added at the end. In C++ and Python, the struct is called `Arm_touched`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gidl.model import (
    AnyDeclaration,
    Attribute,
    Extensibility,
    File,
    Interface,
    Member,
    Model,
    NamedType,
    Operation,
    Struct,
)
from gidl.model.policy import Stream, StreamDirection


def events_as_streams(model: Model) -> Model:
    """Returns `model` without events. @pre the rules found no error in `model`."""
    return Model(tuple(_file(each) for each in model.files))


def _file(file: File) -> File:
    if not any(isinstance(d, Interface) and d.events for d in file.declarations):
        return file
    declarations = (made for each in file.declarations for made in _declarations(each))
    return replace(file, declarations=tuple(declarations))


def _declarations(declaration: AnyDeclaration) -> Iterator[AnyDeclaration]:
    if not isinstance(declaration, Interface):
        yield declaration
        return
    structs = [_parameters(event) for event in declaration.events]
    yield from structs
    yield replace(
        declaration,
        members=tuple(
            _stream(m) if isinstance(m, Operation) and m.is_event else m
            for m in declaration.members
        ),
        nested=(*declaration.nested, *(each.name for each in structs)),
    )


def _parameters(event: Operation) -> Struct:
    members = tuple(
        Member(
            p.name, p.type, p.facts, p.unit, p.range, p.default, p.optional,
            bulk=p.bulk, secret=p.secret,
        )
        for p in event.parameters
    )  # fmt: skip
    facts = replace(event.facts, doc=f"The parameters of the event `{event.name}`.", hash_as=None)
    return Struct(event.scoped_name, facts, members, None, Extensibility.APPENDABLE)


def _stream(event: Operation) -> Attribute:
    return Attribute(
        event.name,
        event.interface,
        NamedType(event.scoped_name),
        True,
        event.facts,
        Stream(StreamDirection.OUT),
        read_access=event.access,
        access_written=event.access_written,
        qos=event.qos,
        id=event.id,
        event=event,
    )
