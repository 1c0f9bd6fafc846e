"""Rule: no member may have a name that gidl generates for an attribute or an event, for example
`set_x` or `publish_x`."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Attribute, Model, Operation
from gidl.rules.walk import meet_first


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        by_name = {m.name.lower(): m for m in model.all_interface_members(interface)}
        for member in by_name.values():
            for generated in _generated(member):
                other = by_name.get(generated.lower())
                if other is None or not meet_first(
                    model, interface, member.interface, other.interface
                ):
                    continue
                what = "attribute" if isinstance(member, Attribute) else "event"
                is_own = interface.name in (member.interface, other.interface)
                findings.error(
                    "G0407",
                    other.facts.location if is_own else interface.facts.location,
                    f"'{other.name}' clashes with a name that is generated for {what} "
                    f"'{member.name}'",
                    "rename one of them",
                    notes=(Note(f"the {what} is declared here", member.facts.location),),
                )


def _generated(member: Operation | Attribute) -> list[str]:
    if isinstance(member, Operation):
        return [f"publish_{member.name}"] if member.is_event else []
    names = []
    if member.has_setter:
        names.append(f"set_{member.name}")
    if member.streams_out:
        names.append(f"publish_{member.name}")
    return names
