"""Rule: the members of an interface and of all its bases must have different names, even without
regard to case."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Attribute, Interface, Model, Operation
from gidl.rules.walk import meet_first


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        inherited = _inherited(model, interface, findings)
        for member in interface.members:
            first = inherited.get(member.name.lower())
            if first is not None:
                findings.error(
                    "G0402",
                    member.facts.location,
                    f"'{member.name}' is inherited from '{first.interface}' and cannot be "
                    "declared again",
                    "IDL has no overriding: rename this member, or remove it",
                    notes=(Note("first declared here", first.facts.location),),
                )


def _inherited(
    model: Model, interface: Interface, findings: Findings
) -> dict[str, Operation | Attribute]:
    """Returns the members of all bases; the keys are the names in lower case. Reports two bases
    that have a member of the same name."""
    found: dict[str, Operation | Attribute] = {}
    for base in interface.all_bases:
        for member in model.interface(base).members:
            first = found.setdefault(member.name.lower(), member)
            same = first.interface == member.interface
            if same or not meet_first(model, interface, first.interface, member.interface):
                continue
            findings.error(
                "G0403",
                interface.facts.location,
                f"'{interface.simple_name}' inherits '{member.name}' from '{first.interface}' and "
                f"from '{member.interface}'",
                "rename one of the members, or declare it in a base that both interfaces share",
                notes=(
                    Note("declared here", first.facts.location),
                    Note("also declared here", member.facts.location),
                ),
            )
    return found
