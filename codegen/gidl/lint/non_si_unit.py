"""Lint: units should be SI units. Programs convert other units where they read the value."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Constant, Location, Model
from gidl.rules.walk import slots

_SI = frozenset(
    """m s kg A K mol cd rad sr Hz N Pa J W C V F ohm S Wb T H lm lx Bq Gy Sv kat 1 bit byte
    count""".split()  # noqa: SIM905
)
_INSTEAD = {
    "mm": "m", "cm": "m", "km": "m", "um": "m", "nm": "m", "in": "m", "ft": "m", "px": "1",
    "ms": "s", "us": "s", "ns": "s", "min": "s", "h": "s", "d": "s",
    "g": "kg", "t": "kg", "L": "m^3", "mL": "m^3",
    "bar": "Pa", "mbar": "Pa", "kPa": "Pa", "MPa": "Pa", "hPa": "Pa", "psi": "Pa",
    "kN": "N", "mN": "N", "lbf": "N", "kHz": "Hz", "MHz": "Hz", "GHz": "Hz", "rpm": "rad/s",
    "kW": "W", "mW": "W", "mV": "V", "kV": "V", "mA": "A", "uA": "A", "kohm": "ohm",
    "Mohm": "ohm", "uF": "F", "nF": "F", "pF": "F", "mJ": "J", "kJ": "J", "Wh": "J", "kWh": "J",
    "deg": "rad", "arcmin": "rad", "arcsec": "rad", "rev": "rad", "degC": "K",
    "kB": "byte", "MB": "byte", "GB": "byte", "%": "1", "ppm": "1", "dB": "1", "pulse": "count",
}  # fmt: skip


def check(model: Model, findings: Findings) -> None:
    for slot in slots(model):
        if slot.unit is not None and slot.facts.has("unit"):
            _unit(slot.unit, slot.what, slot.facts.place_of("unit"), findings)
    for declaration in model.declarations():
        if isinstance(declaration, Constant) and declaration.unit is not None:
            what = f"constant '{declaration.simple_name}'"
            _unit(declaration.unit, what, declaration.facts.place_of("unit"), findings)


def _unit(unit: str, what: str, at: Location, findings: Findings) -> None:
    factors = [factor.partition("^")[0] for factor in unit.replace("/", "*").split("*")]
    strange = next((factor for factor in factors if factor not in _SI), None)
    if strange is None:
        return
    hint = f"use {_INSTEAD[strange]}" if strange in _INSTEAD else "use an SI unit"
    findings.warning(
        "G0905",
        at,
        f"{what} is in '{unit}', and '{strange}' is not an SI unit",
        f"{hint}, and convert the value to this unit in the program",
    )
