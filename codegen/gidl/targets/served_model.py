"""Prints the model that every object serves: its interfaces as JSON, for clients without generated
code.

Each interface has a text of its own, in the format of generated/model. The text has the members
that the interface itself declares, and the types that these members use directly or through other
types. A client asks for the texts of an object's interface and of all its bases. The text has a
line for each declaration and each member, and is plain ASCII.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

from gidl.model import (
    BUILT_IN,
    Attribute,
    Interface,
    Model,
    Type,
)
from gidl.targets.model_json import declaration_json
from gidl.targets.reach import named_types, reached_types
from gidl.wire.wire_layout import Layout


def served_model(model: Model, layout: Layout, interface: Interface) -> str:
    """Returns the text for `interface`. The text is "" for the interface of the built-in
    operations, because every client knows these operations."""
    if interface.name == BUILT_IN:
        return ""
    names = _used(model, interface)
    used = [d for d in model.declarations() if d.name in names]
    types = [d for d in used if not isinstance(d, Interface)]
    references = [d.name for d in used if isinstance(d, Interface)]
    head = declaration_json(model, layout, interface)
    members = head.pop("members", [])
    assert isinstance(members, list)
    parts = [
        f'{{"interface":{_text(head)[:-1]},"members":{_lines(members)}}}',
        f'"types":{_lines([declaration_json(model, layout, d) for d in types])}',
        f'"references":{_text(references)}}}',
    ]
    return ",\n".join(parts)


def _text(value: object) -> str:
    # The text is put into a raw literal: r'''…''' in Python, and R"json(…)json" in C++.
    text = json.dumps(value, separators=(",", ":"))
    return text.replace("'", "\\u0027").replace(")json", ")\\u006ason")


def _lines(values: Sequence[object]) -> str:
    return "[" + ",".join(f"\n{_text(value)}" for value in values) + "]"


def _used(model: Model, interface: Interface) -> set[str]:
    """Returns the names of all declarations that the members of the interface itself need."""
    found = {name for used in _member_types(interface) for name in named_types(used)}
    for member in interface.members:
        raised = (
            (*member.get_raises, *member.set_raises)
            if isinstance(member, Attribute)
            else member.raises
        )
        found.update(raised)
    return reached_types(model, found)


def _member_types(interface: Interface) -> Iterator[Type]:
    for member in interface.members:
        if isinstance(member, Attribute):
            yield member.type
            continue
        yield from (p.type for p in member.parameters)
        yield from (t for t in (member.result, member.feedback) if t is not None)
