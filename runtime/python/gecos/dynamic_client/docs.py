"""Writes the docstrings of dynamic proxies, which equal those of generated proxies."""

from __future__ import annotations

from gecos.dynamic_client.model import Attribute, Model, Operation, Value


def attribute_doc(attribute: Attribute) -> str:
    lines = _noted(attribute.doc, attribute.result)
    if attribute.stream is not None and attribute.stream.rate_hz:
        lines += [""] if lines else []
        rate = f"{attribute.stream.rate_hz:g}"
        lines.append(
            f"Takes {rate} samples a second."
            if attribute.inward
            else f"Published {rate} times a second."
        )
    return "\n".join(lines)


def setter_doc(attribute: Attribute) -> str:
    return "\n".join(_noted(attribute.doc, attribute.result)) or f"Sets {attribute.name}."


def operation_doc(operation: Operation, names: dict[str, str], model: Model) -> str:
    """Returns the docstring of a method. `names` maps names of parameters in the interface to their
    names in Python."""
    lines = _noted(operation.doc, operation.result)
    notes = []
    for each in operation.parameters:
        words = _noted(each.doc, each)
        if words:
            notes.append(f"{names.get(each.name, each.name)}: {' '.join(words)}")
    if operation.raises:
        notes.append(f"May raise {', '.join(map(model.class_name, operation.raises))}.")
    return "\n".join([*lines, *([""] if lines and notes else []), *notes])


def _noted(doc: str, value: Value | None) -> list[str]:
    """Returns the lines of `doc`, with the unit and the range of the value in brackets at the
    end."""
    lines = [line.strip() for line in doc.strip().splitlines()]
    parts = [] if value is None else [each for each in (value.unit, value.range) if each]
    if parts:
        note = f"[{', '.join(parts)}]"
        lines = [*lines[:-1], f"{lines[-1]} {note}"] if lines else [note]
    return lines
