"""Annotations, and arguments of annotations, that gidl accepts although they have no effect in
this version.

`gidl check` warns at each use of such a term, so that nobody relies on the term. A change that
gives a term its effect must remove the line of the term from `NOT_YET`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Facts, File, Interface, Model, Operation, Struct, Union
from gidl.model.bulk import stream_in_place
from gidl.model.policy import Access, QualityClass

CODE = "G0708"

Declared = Interface | Operation | Attribute | None  # None: a struct member, union arm or parameter


def _always(_declared: Declared) -> bool:
    return True


def _needs_status(declared: Declared) -> bool:
    return isinstance(declared, Operation) and declared.access >= Access.ACTOR


def _is_stream(declared: Declared) -> bool:
    if isinstance(declared, Operation):
        return declared.is_event
    return isinstance(declared, Attribute) and declared.stream is not None


def _is_inward(declared: Declared) -> bool:
    return isinstance(declared, Attribute) and declared.streams_in


def _no_real_time(declared: Declared) -> bool:
    return declared is not None and declared.qos.quality_class in (
        None,
        QualityClass.TIME_INDEPENDENT,
    )


def _is_call(declared: Declared) -> bool:
    return isinstance(declared, Operation | Attribute) and not _is_stream(declared)


def _is_member(declared: Declared) -> bool:
    return isinstance(declared, Operation | Attribute)


@dataclass(frozen=True, slots=True)
class Term:
    annotation: str
    argument: str  # name or quoted value of an argument; "": the whole annotation
    applies: Callable[[Declared], bool]
    today: str

    @property
    def written(self) -> str:
        """The key of the term in `Facts.written`, for example "bulk" or "qos.depth"."""
        named = self.argument and not self.argument.startswith('"')
        return f"{self.annotation}.{self.argument}" if named else self.annotation

    def __str__(self) -> str:
        return f"@{self.annotation}({self.argument})" if self.argument else f"@{self.annotation}"


_ALL_RELIABLE = "every sample and call is sent with the reliability of its medium"

NOT_YET = (
    Term(
        "idempotent",
        "",
        _needs_status,
        "a call that needs actor status is not sent again in a new session",
    ),
    Term(
        "bulk",
        "",
        _always,
        "the value is copied; only a sequence<octet> that is the single @bulk member in the "
        "samples of a stream is written and read in place",
    ),
    Term("qos", "latency", _no_real_time, "the latency is checked only with a real-time class"),
    Term("qos", "lifespan", _is_call, "only the samples of a stream have a lifespan"),
    Term("qos", "liveliness", _is_call, "only the writer of a stream must show that it is alive"),
    Term("qos", "start_by", _is_stream, "only a call has a time by which it must start"),
    Term(
        "qos",
        "deadline",
        _is_inward,
        "only the watchdog in @stream limits the silence of the sender",
    ),
    Term("qos", "depth", _is_call, "only a stream keeps earlier samples"),
    Term("qos", "reliability", _is_member, _ALL_RELIABLE),
)


def check(model: Model, findings: Findings) -> None:
    """Warns about the terms of annotations, such as `deadline` of `@qos`, that have no effect yet.
    Looks at the files named on the command line, not at those that they include."""
    in_place = _in_place(model)
    for file in model.files:
        if file.asked_for:
            for declared, name, facts in _annotated(file):
                if id(facts) not in in_place:
                    _one(declared, name, facts, findings)


def _in_place(model: Model) -> set[int]:
    """Returns the ids (of Python's `id()`) of the facts of all members whose @bulk has an
    effect."""
    found = [
        stream_in_place(model, member)
        for interface in model.interfaces()
        for member in interface.members
        if isinstance(member, Attribute)
    ]
    return {id(member.facts) for member in found if member is not None}


def _one(declared: Declared, name: str, facts: Facts, findings: Findings) -> None:
    for term in NOT_YET:
        if facts.has(term.written) and term.applies(declared):
            findings.warning(
                CODE,
                facts.place_of(term.written),
                f"'{term}' of '{name}' has no effect in this version: {term.today}",
            )


def _annotated(file: File) -> Iterator[tuple[Declared, str, Facts]]:
    for declaration in file.declarations:
        match declaration:
            case Interface():
                yield declaration, declaration.simple_name, declaration.facts
                for member in declaration.members:
                    yield member, member.name, member.facts
                    if isinstance(member, Operation):
                        yield from ((None, p.name, p.facts) for p in member.parameters)
            case Struct():
                yield from ((None, m.name, m.facts) for m in declaration.members)
            case Union():
                arms = (case.member for case in declaration.cases)
                yield from ((None, m.name, m.facts) for m in arms)
