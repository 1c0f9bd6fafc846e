"""Function codes: the numbers that identify operations on the wire.

A code is the 32-bit FNV-1a hash of a scoped name, never a position, so reordering the members of an
interface changes no code. The scoped names are:

    operation `move` of robcl::Manipulator:             "robcl::Manipulator::move"
    getter and stream of attribute robcl::Device::base: "robcl::Device::base"
    setter of attribute robcl::Device::base:            "robcl::Device::base="
    exception robcl::OutOfReach:                        "robcl::OutOfReach"

`@id(n)` replaces the hash by n; the setter of an attribute then has the code n + 1.
`@hash_as("old")` on an operation, attribute, exception or interface keeps the code of the old name.
Codes 0 to 255 are reserved: 1 to 255 are for the built-in operations of gecos::GecosObject, and 0
means no operation. Inherited members keep the code of the interface that declares them.
"""

from __future__ import annotations

from gidl.model import Attribute, ExceptionStruct, Facts, Interface, Model, Operation


def fnv1a_32(text: str) -> int:
    value = 0x811C9DC5
    for byte in text.encode("utf-8"):
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return value


def hashed_name(model: Model, name: str, facts: Facts) -> str:
    """Returns the name from which codes and hashes are computed. @hash_as replaces the last part of
    `name`, or all of `name` if the argument of @hash_as contains "::"."""
    if facts.hash_as is not None:
        if "::" in facts.hash_as:
            return facts.hash_as.removeprefix("::")
        scope = name.rpartition("::")[0]
        return f"{scope}::{facts.hash_as}" if scope else facts.hash_as
    return name


def member_name(model: Model, member: Operation | Attribute) -> str:
    """Returns the scoped name of an operation or attribute, from which codes and hashes are
    computed."""
    interface = model.interface(member.interface)
    owner = hashed_name(model, interface.name, interface.facts)
    return hashed_name(model, f"{owner}::{member.name}", member.facts)


def call_code(model: Model, member: Operation | Attribute) -> int:
    """Returns the code of an operation, or of an attribute's getter and stream."""
    return member.id if member.id is not None else fnv1a_32(member_name(model, member))


def setter_code(model: Model, attribute: Attribute) -> int:
    if attribute.id is not None:
        return attribute.id + 1
    return fnv1a_32(member_name(model, attribute) + "=")


def exception_code(model: Model, exception: ExceptionStruct) -> int:
    """Returns the code by which a reply identifies a declared exception."""
    return fnv1a_32(hashed_name(model, exception.name, exception.facts))


def codes_of(
    model: Model, interface: Interface
) -> tuple[tuple[int, str, Operation | Attribute], ...]:
    """Returns the codes of the members that the interface itself declares, in declared order. Each
    code comes with the member, and with the name from which codes and hashes are computed."""
    uses: list[tuple[int, str, Operation | Attribute]] = []
    for member in interface.members:
        name = member_name(model, member)
        uses.append((call_code(model, member), name, member))
        if isinstance(member, Attribute) and member.has_setter:
            uses.append((setter_code(model, member), f"{name}=", member))
    return tuple(uses)
