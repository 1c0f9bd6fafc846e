"""Rule: each value of a union's discriminator selects at most one member."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.model import (
    EnumDeclaration,
    EnumValue,
    Location,
    Model,
    NamedType,
    Primitive,
    Union,
    Value,
)


def check(model: Model, findings: Findings) -> None:
    for declaration in model.declarations():
        if isinstance(declaration, Union) and declaration.cases:
            _union(model, declaration, findings)


def _union(model: Model, union: Union, findings: Findings) -> None:
    seen: dict[Value, Location] = {}
    default: Location | None = None
    for case in union.cases:
        at = case.member.facts.location
        for label in case.labels:
            if label in seen:
                findings.error(
                    "G0315",
                    at,
                    f"label {_shown(label)} selects two members of union '{union.simple_name}'",
                    notes=(Note("the label is first used here", seen[label]),),
                )
            seen.setdefault(label, at)
        if case.is_default:
            if default is not None:
                findings.error(
                    "G0315",
                    at,
                    f"union '{union.simple_name}' has two defaults",
                    notes=(Note("the first default is here", default),),
                )
            default = at
    values = _value_count(model, union)
    if default is not None and values is not None and len(seen) >= values:
        findings.error(
            "G0315",
            default,
            "the default case is never selected, because the labels cover all values",
            "leave out the default case",
        )
    for case in union.cases:
        if case.member.optional or case.member.default is not None:
            findings.error(
                "G0508",
                case.member.facts.place_of("optional", "default"),
                f"member '{case.member.name}' of a union cannot have @optional or @default",
                "leave out @optional and @default",
            )


def _value_count(model: Model, union: Union) -> int | None:
    """Returns the number of values of the discriminator if its type is an enum or boolean; None for
    other types."""
    used = union.discriminator
    if isinstance(used, NamedType):
        enum = model.find(used.name)
        return len(enum.enumerators) if isinstance(enum, EnumDeclaration) else None
    return 2 if used.kind is Primitive.BOOLEAN else None


def _shown(label: Value) -> str:
    if isinstance(label, EnumValue):
        return label.literal
    if isinstance(label, bool):
        return str(label).upper()
    return repr(label)
