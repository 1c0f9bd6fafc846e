"""Rule: no member may have a name that gidl generates for an attribute, for example `set_x` or
`publish_x`."""

from __future__ import annotations

from gidl.diagnostics import Findings, Note
from gidl.model import Attribute, Model
from gidl.rules.walk import meet_first


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        by_name = {m.name.lower(): m for m in model.all_interface_members(interface)}
        for attribute in by_name.values():
            if not isinstance(attribute, Attribute):
                continue
            for generated in _generated(attribute):
                other = by_name.get(generated.lower())
                if other is None or not meet_first(
                    model, interface, attribute.interface, other.interface
                ):
                    continue
                is_own = interface.name in (attribute.interface, other.interface)
                findings.error(
                    "G0407",
                    other.facts.location if is_own else interface.facts.location,
                    f"'{other.name}' clashes with a name that is generated for attribute "
                    f"'{attribute.name}'",
                    "rename one of them",
                    notes=(Note("the attribute is declared here", attribute.facts.location),),
                )


def _generated(attribute: Attribute) -> list[str]:
    names = []
    if attribute.has_setter:
        names.append(f"set_{attribute.name}")
    if attribute.streams_out:
        names.append(f"publish_{attribute.name}")
    return names
