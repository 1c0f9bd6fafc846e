"""Annotations and arguments of annotations that gidl accepts, but that cannot have an effect on the
declaration on which they are written.

`gidl check` warns at each use of such a term, so that nobody relies on the term. Each term has an
effect on declarations of other kinds, which docs/gidl.md lists.
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


def _has_no_calls(declared: Declared) -> bool:
    """Returns whether clients cannot call the declaration: true for an event and an inward stream.
    An outward stream has a getter, which clients call."""
    return _is_stream(declared) and not (isinstance(declared, Attribute) and declared.streams_out)


def _is_inward(declared: Declared) -> bool:
    return isinstance(declared, Attribute) and declared.streams_in


def _no_real_time(declared: Declared) -> bool:
    """Returns whether a latency of the declaration has no effect, because neither the declaration
    nor a member of it has a real-time class. Members inherit the latency of their interface."""
    if declared is None:
        return False
    inheriting = declared.members if isinstance(declared, Interface) else ()
    return all(
        each.qos.quality_class in (None, QualityClass.TIME_INDEPENDENT)
        for each in (declared, *inheriting)
    )


def _no_latency(declared: Declared) -> bool:
    if not isinstance(declared, Interface):
        return False
    return all(each.qos.latency_ns is None for each in (declared, *declared.members))


def _is_call(declared: Declared) -> bool:
    return isinstance(declared, Operation | Attribute) and not _is_stream(declared)


@dataclass(frozen=True, slots=True)
class Term:
    annotation: str
    argument: str  # name or quoted value of an argument; "": the whole annotation
    applies: Callable[[Declared], bool]
    why: str
    instead: str  # what to write instead

    @property
    def written(self) -> str:
        """The key of the term in `Facts.written`, for example "bulk" or "qos.depth"."""
        named = self.argument and not self.argument.startswith('"')
        return f"{self.annotation}.{self.argument}" if named else self.annotation

    def __str__(self) -> str:
        return f"@{self.annotation}({self.argument})" if self.argument else f"@{self.annotation}"


NO_EFFECT = (
    Term(
        "idempotent",
        "",
        _needs_status,
        "a status ends with its session, so the call would be denied in a new session",
        "leave out '@idempotent', or write @sensor if the operation only reads",
    ),
    Term(
        "bulk",
        "",
        _always,
        "the value is copied",
        "write the octets as the one '@bulk sequence<octet>' of a struct, and publish the struct "
        "as a @stream; elsewhere, leave out '@bulk'",
    ),
    Term(
        "qos",
        "latency",
        _no_real_time,
        "TIME_INDEPENDENT promises nothing about time",
        "write class=SOFT_REALTIME or class=HARD_REALTIME, or leave out 'latency'",
    ),
    Term(
        "qos",
        "on_degraded",
        _no_latency,
        "without a latency, the connection has no limit that it could exceed",
        "write 'latency' and a real-time class, or leave out 'on_degraded'",
    ),
    Term(
        "qos",
        "lifespan",
        _is_call,
        "only the samples of a stream have a lifespan",
        "write 'start_by' or 'deadline' to limit the age of a call",
    ),
    Term(
        "qos",
        "liveliness",
        _is_call,
        "only the writer of a stream must show that it is alive",
        "leave out 'liveliness': the session shows that the caller and the server are alive",
    ),
    Term(
        "qos",
        "start_by",
        _has_no_calls,
        "only a call waits to be started",
        "write 'lifespan' to limit the age of a sample",
    ),
    Term(
        "qos",
        "deadline",
        _is_inward,
        "the time between two samples of a client is limited by 'watchdog' alone",
        "write 'watchdog' in @stream",
    ),
    Term(
        "qos",
        "depth",
        _is_call,
        "only a stream keeps earlier samples",
        "leave out 'depth'",
    ),
)


def check(model: Model, findings: Findings) -> None:
    """Warns about the terms of annotations, such as `depth` of `@qos`, that have no effect. Looks
    at the files named on the command line, not at those that they include."""
    in_place = _in_place(model)
    bases = {base for interface in model.interfaces() for base in interface.bases}
    for file in model.files:
        if file.asked_for:
            for declared, name, facts in _annotated(file):
                # A derived interface may declare a real-time class. A term that it inherits from a
                # base then has an effect, so bases are not checked.
                is_base = isinstance(declared, Interface) and declared.name in bases
                if id(facts) not in in_place and not is_base:
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
    for term in NO_EFFECT:
        if facts.has(term.written) and term.applies(declared):
            findings.warning(
                CODE,
                facts.place_of(term.written),
                f"'{term}' of '{name}' has no effect: {term.why}",
                term.instead,
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
