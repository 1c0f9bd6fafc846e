"""Rule: the numbers of enumerators and flags are distinct, and fit the bits of their type."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Bitmask, Bitset, EnumDeclaration, Location, Model


def check(model: Model, findings: Findings) -> None:
    for declaration in model.declarations():
        match declaration:
            case EnumDeclaration():
                _enum(declaration, findings)
            case Bitmask():
                _bitmask(declaration, findings)
            case Bitset() if declaration.bit_size > 64:
                findings.error(
                    "G0318",
                    declaration.facts.location,
                    f"bitset '{declaration.simple_name}' has {declaration.bit_size} bits, at most "
                    "64 are possible",
                    "split the bitset, or use a struct",
                )


def _enum(enum: EnumDeclaration, findings: Findings) -> None:
    seen: dict[int, tuple[str, Location]] = {}
    least, most = -(1 << (enum.bit_bound - 1)), (1 << enum.bit_bound) - 1
    for enumerator in enum.enumerators:
        at = enumerator.facts.place_of("value")
        first = seen.setdefault(enumerator.number, (enumerator.name, enumerator.facts.location))
        if first[0] != enumerator.name:
            findings.error(
                "G0317",
                at,
                f"'{enumerator.name}' has the same number {enumerator.number} as '{first[0]}'",
                notes=(Note("the number is first used here", first[1]),),
            )
        if not least <= enumerator.number <= min(most, (1 << 31) - 1):
            findings.error(
                "G0317",
                at,
                f"the number {enumerator.number} of '{enumerator.name}' does not fit "
                f"{enum.bit_bound} bits",
            )


def _bitmask(mask: Bitmask, findings: Findings) -> None:
    seen: dict[int, tuple[str, Location]] = {}
    for flag in mask.flags:
        at = flag.facts.place_of("position")
        first = seen.setdefault(flag.position, (flag.name, flag.facts.location))
        if first[0] != flag.name:
            findings.error(
                "G0317",
                at,
                f"'{flag.name}' has the same bit {flag.position} as '{first[0]}'",
                notes=(Note("the number is first used here", first[1]),),
            )
        if flag.position >= mask.bit_bound:
            findings.error(
                "G0317",
                at,
                f"bit {flag.position} of '{flag.name}' is outside the {mask.bit_bound} bits of "
                f"'{mask.simple_name}'",
                "write @bit_bound(64) before 'bitmask' for up to 64 flags",
            )
