"""Rules for open streams, whose samples any LCM tool can read over lcm."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.diagnostics.findings import Findings
from gidl.model import (
    AnyDeclaration,
    Attribute,
    Member,
    Model,
    NamedType,
    Struct,
    Typedef,
    Union,
)
from gidl.model.declarations import Extensibility
from gidl.model.policy import Access, QualityClass, Reliability
from gidl.model.types import named_in
from gidl.rules.walk import members

CODE = "G0411"


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if not isinstance(member, Attribute) or member.stream is None or not member.stream.is_open:
            continue
        _type(model, member, findings)
        _readers(member, findings)
        _quality(member, findings)


def _type(model: Model, attribute: Attribute, findings: Findings) -> None:
    at = attribute.facts.place_of("open_stream")
    target = model.target(attribute.type)
    declaration = model.find(target.name) if isinstance(target, NamedType) else None
    if attribute.streams_in:
        findings.error(CODE, at, "only a stream that the server publishes can be an open stream")
    elif not isinstance(declaration, Struct) or declaration.is_appendable or attribute.optional:
        findings.error(
            CODE,
            at,
            f"samples of an open stream are plain LCM messages, but '{attribute.name}' is not "
            "a final struct",
            "use a struct that is not @appendable",
        )
    else:
        _content(model, attribute, declaration, findings)


def _content(model: Model, attribute: Attribute, sample: Struct, findings: Findings) -> None:
    """Reports the types inside a sample that LCM tools cannot decode, and the members that are
    @secret."""
    at = attribute.facts.place_of("open_stream")
    for declaration in _contained(model, sample):
        if _is_appendable(declaration):
            findings.error(
                CODE,
                at,
                f"'{attribute.name}' contains '{declaration.name}', which is @appendable: LCM "
                "tools would show this type as bytes",
                f"make '{declaration.name}' @final, or leave out '@open_stream'",
            )
        for member in _members(declaration):
            if member.secret:
                findings.error(
                    CODE,
                    at,
                    f"anybody who receives the packets of an open stream can read the samples, but "
                    f"'{attribute.name}' contains '{declaration.name}', whose member "
                    f"'{member.name}' is @secret",
                    "leave out '@open_stream', or publish a struct without secrets",
                )


def _readers(attribute: Attribute, findings: Findings) -> None:
    if attribute.read_access is not Access.SENSOR:
        findings.error(
            CODE,
            attribute.facts.place_of("open_stream"),
            f"anybody can read an open stream, but a client needs "
            f"{attribute.read_access.name.lower()} status to read '{attribute.name}'",
            "leave out '@open_stream', or write @sensor",
        )


def _quality(attribute: Attribute, findings: Findings) -> None:
    at = attribute.facts.place_of("open_stream")
    if attribute.qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        findings.error(
            CODE,
            at,
            "an open stream is not authenticated, so it never satisfies a real-time class",
            "leave out '@open_stream', or the class in '@qos'",
        )
    if attribute.qos.reliability is Reliability.RELIABLE:
        findings.error(
            CODE,
            at,
            "an open stream is sent over lcm, which may lose samples, so it is never RELIABLE",
            "leave out '@open_stream', or the reliability in '@qos'",
        )
    if attribute.qos.media is not None and "lcm" not in attribute.qos.media:
        findings.error(
            CODE,
            at,
            f"the plain LCM messages of an open stream are sent over lcm, but '{attribute.name}' "
            f'may use only "{"|".join(attribute.qos.media)}"',
            "add lcm to 'media' in '@qos', or leave out '@open_stream'",
        )


def _contained(model: Model, first: AnyDeclaration) -> list[AnyDeclaration]:
    """Returns the type `first` and all types inside it, directly or indirectly. Each type comes
    only once."""
    met = {first.name: first}
    work = [first]
    while work:
        for name in _used(work.pop(0)):
            if name not in met:
                met[name] = model.find(name)
                work.append(met[name])
    return list(met.values())


def _used(declaration: AnyDeclaration) -> Iterator[str]:
    if isinstance(declaration, Struct) and declaration.base is not None:
        yield declaration.base
    if isinstance(declaration, Typedef):
        yield from named_in(declaration.type)
    for member in _members(declaration):
        yield from named_in(member.type)


def _members(declaration: AnyDeclaration) -> tuple[Member, ...]:
    match declaration:
        case Struct(members=found):
            return found
        case Union(cases=cases):
            return tuple(case.member for case in cases)
        case _:
            return ()


def _is_appendable(declaration: AnyDeclaration) -> bool:
    return (
        isinstance(declaration, Struct | Union)
        and declaration.extensibility is Extensibility.APPENDABLE
    )
