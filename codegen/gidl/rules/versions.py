"""Rule: a version has the form MAJOR.MINOR, and the argument of @hash_as is a name."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gidl.diagnostics.findings import Findings
from gidl.model import EnumDeclaration, Facts, Interface, Model, Operation, Struct

_VERSION = re.compile(r"(0|[1-9]\d{0,5})\.(0|[1-9]\d{0,5})\Z")
_NAME = re.compile(r"(::)?[A-Za-z]\w*(::[A-Za-z]\w*)*\Z")


def check(model: Model, findings: Findings) -> None:
    for facts in _all_facts(model):
        for annotation, text in (("version", facts.version), ("since", facts.since)):
            if text is not None and not _VERSION.match(text):
                findings.error(
                    "G0512",
                    facts.place_of(annotation),
                    f"'{text}' is not a version",
                    'write "MAJOR.MINOR", such as "1.2"',
                )
        if facts.hash_as is not None and not _NAME.match(facts.hash_as):
            findings.error(
                "G0512",
                facts.place_of("hash_as"),
                f"the argument '{facts.hash_as}' of @hash_as is not a name",
            )
    for interface in model.interfaces():
        _since_within(interface, findings)


def _since_within(interface: Interface, findings: Findings) -> None:
    """Reports each member whose @since names a later version than the @version of its interface."""
    version = _key(interface.facts.version)
    for member in interface.members:
        since = _key(member.facts.since)
        if version is not None and since is not None and since > version:
            findings.error(
                "G0512",
                member.facts.place_of("since"),
                f"'{member.name}' exists since version {member.facts.since}, but interface "
                f"'{interface.simple_name}' has version {interface.facts.version}",
                "raise the version of the interface, or correct @since",
            )


def _key(text: str | None) -> tuple[int, int] | None:
    match = _VERSION.match(text or "")
    return (int(match.group(1)), int(match.group(2))) if match else None


def _all_facts(model: Model) -> Iterator[Facts]:
    for file in model.files:
        for module in file.modules:
            yield module.facts
    for declaration in model.declarations():
        yield declaration.facts
        match declaration:
            case Struct():
                yield from (m.facts for m in declaration.members)
            case EnumDeclaration():
                yield from (e.facts for e in declaration.enumerators)
            case Interface():
                for member in declaration.members:
                    yield member.facts
                    if isinstance(member, Operation):
                        yield from (p.facts for p in member.parameters)
