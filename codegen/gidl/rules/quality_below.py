"""Rule: a member must not promise less quality than its interface, and an interface must not
promise less quality than any of its bases. An interface that declares no quality can also break
this rule, because it inherits each term from the first base that has the term."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Attribute, Facts, Interface, Model, Operation
from gidl.model.policy import Qos

_OF_MEMBER = (
    "give the member a quality that is at least that of its interface, weaken the quality of the "
    "interface, or move the member to another interface"
)
_OF_BASE = (
    "write @qos before the interface, with a quality that is at least that of every base. If you "
    "leave a term out, the interface inherits it from the first base that has it"
)


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        for base in interface.bases:
            name, above = interface.simple_name, model.interface(base)
            _compare(name, interface.qos, interface.facts, above, _OF_BASE, findings)
        for member in interface.members:
            if member.facts.has("qos"):
                own = _comparable(member)
                _compare(member.name, own, member.facts, interface, _OF_MEMBER, findings)


def _comparable(member: Operation | Attribute) -> Qos:
    """Returns the quality of `member` without the terms in which `member` may be weaker than its
    interface. One of them is the reliability of a stream or event: it applies to samples, but the
    reliability of an interface applies to calls."""
    own = member.qos
    if member.sends_samples:
        own = replace(own, reliability=None, depth=None, lifespan_ns=None)
    if isinstance(member, Attribute) and member.stream is not None and member.stream.is_open:
        own = replace(own, quality_class=None)
    return own


def _compare(
    name: str, own: Qos, facts: Facts, above: Interface, advice: str, findings: Findings
) -> None:
    for said in _weaker(own, above.qos):
        findings.error(
            "G0413",
            facts.place_of("qos"),
            f"'{name}' promises less than interface '{above.simple_name}': {said}",
            advice,
            notes=(Note("promised here", above.facts.place_of("qos")),),
        )


def _weaker(own: Qos, above: Qos) -> Iterator[str]:
    """Yields a text for each quality term of `own` that is weaker than in `above`."""
    for term in ("quality_class", "reliability", "liveliness"):
        mine, theirs = getattr(own, term), getattr(above, term)
        if mine is not None and theirs is not None and mine < theirs:
            yield f"{mine.name} is weaker than {theirs.name}"
    for term in ("deadline", "start_by", "latency"):
        mine, theirs = getattr(own, f"{term}_ns"), getattr(above, f"{term}_ns")
        if mine is not None and theirs is not None and mine > theirs:
            yield f"its {term} {_shown(mine)} is longer than {_shown(theirs)}"
    if own.media is not None and above.media is not None:
        more = [medium for medium in own.media if medium not in above.media]
        if more:
            yield f"{', '.join(more)} is not among the media {', '.join(above.media)}"


def _shown(nanoseconds: int) -> str:
    for unit, size in (("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000)):
        if nanoseconds >= size:
            return f"{nanoseconds / size:g}{unit}"
    return f"{nanoseconds}ns"
