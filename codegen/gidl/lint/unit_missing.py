"""Lint: a floating-point number with the name of a physical quantity should declare its unit."""

from __future__ import annotations

import re

from gidl.diagnostics.findings import Findings
from gidl.model import ArrayType, MapType, Model, NamedType, SequenceType, Type, Typedef
from gidl.rules.walk import Slot, numeric_core, slots

# A name is judged by the last of its words that this table lists: `tool_speed` is a speed, and
# `force_threshold` is a force.
_UNITS = {
    "m": """distance length width height depth radius diameter range reach position offset
            opening stroke gap clearance thickness translation elevation altitude path""",
    "rad": "angle rotation roll pitch yaw heading azimuth tilt joint turn orientation",
    "m/s": "speed velocity",
    "m/s^2": "acceleration deceleration",
    "m/s^3": "jerk",
    "N": "force thrust tension",
    "N*m": "torque moment",
    "kg": "mass weight payload load",
    "kg*m^2": "inertia",
    "s": """time duration delay timeout period interval age stamp timestamp latency deadline
            elapsed remaining since until""",
    "Hz": "frequency rate bandwidth",
    "K": "temperature",
    "Pa": "pressure stress",
    "V": "voltage",
    "A": "current",
    "W": "power",
    "J": "energy work",
    "C": "charge",
    "ohm": "resistance",
    "m^2": "area",
    "m^3": "volume",
    "N/m": "stiffness",
    "N*s/m": "damping",
}
_UNIT_OF = {word: unit for unit, words in _UNITS.items() for word in words.split()}
_PURE = frozenset(
    """fraction ratio scale factor count number percent gain relative normalized confidence score
    probability index""".split()  # noqa: SIM905
)
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")


def check(model: Model, findings: Findings) -> None:
    for slot in slots(model):
        core = numeric_core(model, slot.type)
        if core is None or not core.kind.is_floating or _has_unit(model, slot):
            continue
        if slot.what.startswith("type ") or _is_fraction(slot):
            # A typedef needs no unit, because each member of this type can declare one. A number
            # whose range is within [-1, 1] is taken for a fraction, which has no unit.
            continue
        name = _name(slot)
        if name is None:
            continue
        quantity, unit = _quantity(name)
        if quantity:
            findings.warning(
                "G0901",
                slot.facts.location,
                f"{slot.what} is named like a physical quantity ({quantity}) and has no unit",
                f'write @unit("{unit}"), or @unit("1") if the number has no unit',
            )


def _is_fraction(slot: Slot) -> bool:
    bounds = slot.range
    if bounds is None or bounds.minimum is None or bounds.maximum is None:
        return False
    return bounds.minimum >= -1 and bounds.maximum <= 1


def _name(slot: Slot) -> str | None:
    match = re.search(r"'(\w+)'", slot.what)
    return match.group(1) if match else None


def _quantity(name: str) -> tuple[str, str]:
    words = [word.lower() for word in _WORD.findall(name)]
    if _PURE & set(words):
        return "", ""
    for word in reversed(words):
        singular = word.removesuffix("s") if word.removesuffix("s") in _UNIT_OF else word
        if singular in _UNIT_OF:
            return singular, _UNIT_OF[singular]
    return "", ""


def _has_unit(model: Model, slot: Slot) -> bool:
    return slot.unit is not None or _inside(model, slot.type)


def _inside(model: Model, used: Type) -> bool:
    """Returns whether a typedef or a sequence inside the type declares a unit."""
    match used:
        case SequenceType(element, _, unit):
            return unit is not None or _inside(model, element)
        case ArrayType(element=element):
            return _inside(model, element)
        case MapType(value=value):
            return _inside(model, value)
        case NamedType(name):
            declaration = model.find(name)
            if isinstance(declaration, Typedef):
                return declaration.unit is not None or _inside(model, declaration.type)
    return False
