"""Finds the declarations that another declaration uses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gidl.model import (
    Bitset,
    Constant,
    EnumValue,
    Facts,
    File,
    Interface,
    Model,
    Operation,
    Struct,
    Type,
    Typedef,
    Union,
    Value,
)
from gidl.model.types import named_in


@dataclass(frozen=True, slots=True)
class Use:
    name: str  # scoped name of the used declaration
    what: str  # what uses `name`, in the words of messages: for example "member 'pose'"
    facts: Facts  # facts of the member or declaration that uses `name`
    by_deprecated: bool  # True: the declaration that uses `name` is deprecated


def uses(model: Model, file: File) -> Iterator[Use]:
    """Yields all uses of declarations in a file, in the order of the file."""
    for declaration in file.declarations:
        facts = declaration.facts
        old = facts.deprecated is not None
        what = f"'{declaration.simple_name}'"
        match declaration:
            case Struct():
                if declaration.base is not None:
                    yield Use(declaration.base, what, facts, old)
                for m in declaration.members:
                    yield from _slot(m.type, m.default, f"member '{m.name}'", m.facts, old)
            case Union():
                yield from _slot(declaration.discriminator, None, what, facts, old)
                for case in declaration.cases:
                    m = case.member
                    yield from _slot(m.type, m.default, f"member '{m.name}'", m.facts, old)
            case Bitset() if declaration.base is not None:
                yield Use(declaration.base, what, facts, old)
            case Typedef():
                yield from _slot(declaration.type, None, what, facts, old)
            case Constant():
                yield from _slot(declaration.type, declaration.value, what, facts, old)
            case Interface():
                for base in declaration.bases:
                    yield Use(base, what, facts, old)
                yield from _members(declaration, old)


def _members(interface: Interface, old: bool) -> Iterator[Use]:
    for member in interface.members:
        is_old = old or member.facts.deprecated is not None
        if isinstance(member, Operation):
            what = f"operation '{member.name}'"
            if member.result is not None:
                yield from _slot(member.result, None, what, member.facts, is_old)
            if member.feedback is not None:
                yield from _slot(member.feedback, None, what, member.facts, is_old)
            for p in member.parameters:
                yield from _slot(p.type, p.default, f"parameter '{p.name}'", p.facts, is_old)
            raised = member.raises
        else:
            what = f"attribute '{member.name}'"
            yield from _slot(member.type, None, what, member.facts, is_old)
            raised = (*member.get_raises, *member.set_raises)
        for name in raised:
            yield Use(name, what, member.facts, is_old)


def _slot(used: Type, default: Value | None, what: str, facts: Facts, old: bool) -> Iterator[Use]:
    is_old = old or facts.deprecated is not None
    for name in named_in(used):
        yield Use(name, what, facts, is_old)
    if isinstance(default, EnumValue):
        yield Use(default.enum, what, facts, is_old)


def declared_names(model: Model, name: str) -> set[str]:
    """Returns the names of the declarations that the declaration `name` uses."""
    for file in model.files:
        if file.path == model.file_of(name):
            only = File(file.path, (), (model.find(name),))
            return {use.name for use in uses(model, only)}
    return set()
