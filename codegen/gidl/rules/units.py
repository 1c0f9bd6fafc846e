"""Rule: a unit consists of known units, and only numbers have a unit."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, suggestion
from gidl.model import (
    ArrayType,
    Constant,
    Facts,
    Location,
    MapType,
    Model,
    SequenceType,
    Type,
)
from gidl.rules.walk import numeric_core, slots


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# SI units, and other units that are accepted. @unit takes a product of these units, for example
# "N*m" or "m/s^2".
BASE_UNITS = _words(
    """
    m s kg A K mol cd rad sr Hz N Pa J W C V F ohm S Wb T H lm lx Bq Gy Sv kat 1 mm cm km um nm
    ms us ns min h d g t L mL bar mbar kPa MPa hPa kN mN kHz MHz GHz kW mW mV kV mA uA kohm Mohm
    uF nF pF mJ kJ Wh kWh deg arcmin arcsec rpm degC rev in ft lbf px bit byte kB MB GB % ppm dB
    count pulse
    """
)
SPELLED = {
    "meter": "m", "metre": "m", "meters": "m", "second": "s", "seconds": "s", "sec": "s",
    "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "newton": "N",
    "kilogram": "kg", "celsius": "degC", "percent": "%", "hertz": "Hz", "hz": "Hz", "volt": "V",
    "Nm": "N*m", "Ω": "ohm", "°": "deg", "°C": "degC", "µm": "um", "µs": "us",
}  # fmt: skip


def check(model: Model, findings: Findings) -> None:
    for slot in slots(model):
        if slot.unit is not None and slot.facts.has("unit"):
            at = slot.facts.place_of("unit")
            _known(slot.unit, at, findings)
            _on_number(model, slot.type, slot.what, at, findings)
        _inside(model, slot.type, slot.facts, findings)
    for declaration in model.declarations():
        if isinstance(declaration, Constant) and declaration.unit is not None:
            at = declaration.facts.place_of("unit")
            _known(declaration.unit, at, findings)
            what = f"constant '{declaration.simple_name}'"
            _on_number(model, declaration.type, what, at, findings)


def _inside(model: Model, used: Type, facts: Facts, findings: Findings) -> None:
    """Checks the units that sequences inside a type declare."""
    match used:
        case SequenceType(element, _, unit):
            if unit is not None:
                _known(unit, facts.location, findings)
                what = "the element of this sequence"
                _on_number(model, element, what, facts.location, findings)
            _inside(model, element, facts, findings)
        case ArrayType(element=element):
            _inside(model, element, facts, findings)
        case MapType(value=value):
            _inside(model, value, facts, findings)


def is_known(unit: str) -> bool:
    for factor in unit.replace("/", "*").split("*"):
        base, caret, power = factor.partition("^")
        if base not in BASE_UNITS or (caret and not power.lstrip("-").isdigit()):
            return False
    return True


def _known(unit: str, at: Location, findings: Findings) -> None:
    if is_known(unit):
        return
    hint = f"write '{SPELLED[unit]}'" if unit in SPELLED else ""
    if unit.isalpha():
        hint = hint or suggestion(unit, _NAMES)
    findings.error(
        "G0507",
        at,
        f"unknown unit '{unit}'",
        hint
        or "write a product of known units, such as m/s, rad/s^2 or N*m; docs/gidl.md lists them",
    )


def _on_number(model: Model, used: Type, what: str, at: Location, findings: Findings) -> None:
    if numeric_core(model, used) is None:
        findings.error("G0509", at, f"{what} is not a number, so it cannot have a unit")


_NAMES = {unit: "" for unit in BASE_UNITS if len(unit) > 1}
