"""Resolves interfaces, operations and attributes: turns their syntax into declarations of the
model."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TypeVar

from gidl.diagnostics.findings import Findings
from gidl.model import (
    Attribute,
    Direction,
    Interface,
    NamedType,
    Operation,
    Parameter,
)
from gidl.model.policy import (
    Access,
    Liveliness,
    OnDegraded,
    OnLoss,
    OnNew,
    Qos,
    QualityClass,
    Reliability,
    Stream,
    StreamDirection,
)
from gidl.resolve.quantities import duration_ns, rate_hz
from gidl.resolve.scopes import Names, Scope
from gidl.resolve.types import TypeResolver
from gidl.resolve.values import Marks
from gidl.resolve.vocabulary import Applied, Vocabulary
from gidl.syntax.tree import (
    AttributeSyntax,
    DeclarationSyntax,
    InterfaceSyntax,
    Name,
    OperationSyntax,
    ParameterSyntax,
    ScopedName,
)

_INTERFACE = frozenset(("interface",))
_EXCEPTION = frozenset(("exception",))
_STRUCT = frozenset(("struct",))
_Choice = TypeVar("_Choice", OnNew, OnLoss)
_Number = TypeVar("_Number", int, float)
MAX_BASES = 64
MEDIA = ("inproc", "shm", "lcm", "tcp", "can")
_DURATIONS = "ns, us, ms, s, min or h"


class InterfaceResolver(TypeResolver):
    def __init__(self, findings: Findings, names: Names, vocabulary: Vocabulary) -> None:
        super().__init__(findings, names, vocabulary)
        self._interface_scopes: dict[str, Scope] = {}
        self._interface_qos: dict[str, Qos] = {}
        self._all_bases: dict[str, tuple[str, ...]] = {}
        # Interfaces that had too many bases, and the interfaces that derive from them. All bases of
        # these interfaces were removed.
        self._cut_off: set[str] = set()

    def _interface(self, syntax: InterfaceSyntax, scope: Scope) -> None:
        marks = self._marks(syntax.extras, "interface", scope)
        bases: list[str] = []
        inside = Scope(scope.qualified(syntax.name.text), "interface", scope)
        for base in syntax.bases:
            found = self._complete(base, scope, _INTERFACE, "interface")
            if found is None:
                continue
            if found in bases:
                self._findings.error(
                    "G0401", base.span, f"'{base}' is listed as a base twice", "name each base once"
                )
                continue
            bases.append(found)
        bases = self._few_enough(syntax, inside.name, bases)
        inside.bases += [self._interface_scopes[base_name] for base_name in bases]
        symbol = self._names.declare(scope, syntax.name, "interface")
        if symbol is not None:
            symbol.scope = inside
        self._interface_scopes.setdefault(inside.name, inside)
        qos = self._qos(marks)
        for base_name in bases:
            qos = qos.over(self._interface_qos[base_name])
        self._interface_qos.setdefault(inside.name, qos)
        all_bases = self._linearised(bases)
        self._all_bases.setdefault(inside.name, all_bases)
        members: list[Operation | Attribute] = []
        first_nested = len(self._out)
        for item in syntax.body:
            if isinstance(item, OperationSyntax):
                operation = self._operation(item, inside, qos)
                if operation is not None:
                    members.append(operation)
            elif isinstance(item, AttributeSyntax):
                members.extend(self._attribute(item, inside, qos))
            else:
                self._declaration(item, inside)
        nested = tuple(d.name for d in self._out[first_nested:])
        facts = self._facts(syntax.name, syntax.extras, marks)
        self._keep(
            symbol,
            Interface(inside.name, facts, tuple(bases), all_bases, tuple(members), nested, qos),
        )

    def _few_enough(self, syntax: InterfaceSyntax, name: str, bases: list[str]) -> list[str]:
        """Returns `bases`. If an interface has too many bases, adds a finding and returns an empty
        list. An interface that derives from this one loses its bases too, but without a finding."""
        if not self._cut_off.isdisjoint(bases):
            self._cut_off.add(name)
            return []
        count = len(self._linearised(bases))
        if count <= MAX_BASES:
            return bases
        self._cut_off.add(name)
        self._findings.error(
            "G0414",
            syntax.name.span,
            f"'{syntax.name.text}' has {count} direct and indirect bases; at most "
            f"{MAX_BASES} are allowed",
            "move members of several bases into one base",
        )
        return []

    @abstractmethod
    def _declaration(self, syntax: DeclarationSyntax, scope: Scope) -> None: ...

    def _linearised(self, bases: list[str]) -> tuple[str, ...]:
        found: list[str] = []
        for base in bases:
            for name in (*self._all_bases.get(base, ()), base):
                if name not in found:
                    found.append(name)
        return tuple(found)

    # -- operation -----------------------------------------------------------------------------

    def _operation(self, syntax: OperationSyntax, scope: Scope, outer: Qos) -> Operation | None:
        marks = self._marks(syntax.extras, "operation", scope)
        result = None if syntax.result is None else self._whole(syntax.result, scope)
        broken = syntax.result is not None and result is None
        symbol = self._names.declare(scope, syntax.name, "operation")
        inside = Scope(scope.qualified(syntax.name.text), "operation", scope)
        parameters = []
        for parameter in syntax.parameters:
            found = self._parameter(parameter, inside)
            if found is None:
                broken = True
            else:
                parameters.append(found)
        raises = self._raises(syntax.raises, scope)
        access, written = self._access(marks)
        is_event = "event" in marks
        if not written:
            access = Access.SENSOR if is_event else Access.ACTOR
        presence = marks.get("presence")
        needs_presence = access >= Access.ACTOR and not is_event
        if presence is not None:
            needs_presence = marks.flag("presence")
        cancelable = marks.get("cancelable")
        feedback = None if cancelable is None else self._feedback(cancelable, scope)
        made = Operation(
            syntax.name.text,
            scope.name,
            tuple(parameters),
            result,
            self._facts(syntax.name, syntax.extras, marks),
            raises,
            syntax.oneway,
            is_event,
            access,
            written,
            "safety" in marks,
            needs_presence,
            "idempotent" in marks,
            cancelable is not None,
            feedback,
            self._choice(marks, "on_new", OnNew, OnNew.QUEUE),
            "parallel" in marks,
            "ordered" in marks,
            self._choice(marks, "on_loss", OnLoss, OnLoss.STOP),
            self._qos(marks).over(outer.inherited_by_samples if is_event else outer),
            None if result is None else self._unit(marks, result),
            None if result is None else self._range(marks, result),
            marks.flag("optional"),
            "bulk" in marks,
            "secret" in marks,
            marks.number("id"),
        )
        return None if broken or symbol is None else made

    def _parameter(self, syntax: ParameterSyntax, scope: Scope) -> Parameter | None:
        marks = self._marks(syntax.extras, "parameter", scope)
        used = self._whole(syntax.type, scope)
        symbol = self._names.declare(scope, syntax.name, "parameter")
        if used is None or symbol is None:
            return None
        return Parameter(
            syntax.name.text,
            used,
            Direction(syntax.direction),
            self._facts(syntax.name, syntax.extras, marks),
            self._unit(marks, used),
            self._range(marks, used),
            self._default(marks, used),
            marks.flag("optional"),
            "secret" in marks,
            "bulk" in marks,
        )

    def _raises(self, names: list[ScopedName], scope: Scope) -> tuple[str, ...]:
        found: list[str] = []
        for name in names:
            symbol = self._symbol(name, scope, _EXCEPTION, "exception", "G0405")
            if symbol is not None and symbol.scoped not in found:
                found.append(symbol.scoped)
        return tuple(found)

    def _feedback(self, cancelable: Applied, scope: Scope) -> NamedType | None:
        text = cancelable.text("feedback")
        if not text:
            return None
        parts = tuple(text.removeprefix("::").split("::"))
        name = ScopedName(parts, text.startswith("::"), cancelable.span)
        quiet = Scope(scope.name, scope.kind, scope)  # the lookup must not change scope.uses
        feedback = self._complete(name, quiet, _STRUCT, "struct")
        return None if feedback is None else NamedType(feedback)

    def _access(self, marks: Marks) -> tuple[Access, bool]:
        said = [a for a in Access if a.name.lower() in marks]
        if len(said) > 1:
            second = marks.get(said[1].name.lower())
            assert second is not None
            both = " and ".join(f"'@{a.name.lower()}'" for a in said)
            self._findings.error(
                "G0505",
                second.span,
                f"{both} contradict each other",
                "write only one of these annotations",
            )
        return (said[-1], True) if said else (Access.ACTOR, False)

    def _choice(self, marks: Marks, name: str, kind: type[_Choice], unsaid: _Choice) -> _Choice:
        applied = marks.get(name)
        if applied is None:
            return unsaid
        text = applied.text()
        for choice in kind:
            if choice.value == text:
                return choice
        known = ", ".join(f'"{c.value}"' for c in kind)
        self._findings.error(
            "G0506", applied.span, f"'@{name}' has no value \"{text}\"", f"write one of {known}"
        )
        return unsaid

    # -- attribute -----------------------------------------------------------------------------

    def _attribute(self, syntax: AttributeSyntax, scope: Scope, outer: Qos) -> list[Attribute]:
        marks = self._marks(syntax.extras, "attribute", scope)
        used = self._whole(syntax.type, scope)
        get_raises = self._raises(syntax.get_raises, scope)
        set_raises = self._raises(syntax.set_raises, scope)
        stream = self._stream(marks)
        access, written = self._access(marks)
        inward = stream is not None and stream.direction is StreamDirection.IN
        of_writing = inward or not syntax.readonly
        read = access if written and not of_writing else Access.SENSOR
        write = access if written and of_writing else Access.ACTOR
        needs_presence = write >= Access.ACTOR
        if "presence" in marks:
            needs_presence = marks.flag("presence")
        inherited = outer if stream is None else outer.inherited_by_samples
        qos = self._qos(marks).over(inherited)
        found: list[Attribute] = []
        for name in syntax.names:
            symbol = self._names.declare(scope, name, "attribute")
            if symbol is None or used is None:
                continue
            found.append(
                Attribute(
                    name.text,
                    scope.name,
                    used,
                    syntax.readonly,
                    self._facts(name, syntax.extras, marks),
                    stream,
                    read,
                    write,
                    written,
                    needs_presence,
                    get_raises,
                    set_raises,
                    qos,
                    self._unit(marks, used),
                    self._range(marks, used),
                    marks.flag("optional"),
                    "secret" in marks,
                    "bulk" in marks,
                    None if found else marks.number("id"),
                )
            )
        self._one_id_each(marks, syntax.names)
        return found

    def _one_id_each(self, marks: Marks, names: list[Name]) -> None:
        applied = marks.get("id")
        if applied is not None and len(names) > 1:
            self._findings.error(
                "G0601",
                applied.span,
                "these attributes would share one '@id'",
                "declare each attribute separately",
            )

    def _stream(self, marks: Marks) -> Stream | None:
        applied = marks.get("stream")
        if applied is None:
            return None
        direction = applied.text("dir")
        if direction not in ("in", "out"):
            self._findings.error(
                "G0506",
                applied.span,
                f'the direction of a stream cannot be "{direction}"',
                'write dir="out" if the server sends, or dir="in" if clients send',
            )
        rate = self._quantity(applied, "rate", rate_hz, "mHz, Hz or kHz", "250Hz")
        watchdog = self._quantity(applied, "watchdog", duration_ns, _DURATIONS, "48ms")
        way = StreamDirection.IN if direction == "in" else StreamDirection.OUT
        return Stream(way, rate, watchdog, "open_stream" in marks)

    # -- quality -------------------------------------------------------------------------------

    def _qos(self, marks: Marks) -> Qos:
        applied = marks.get("qos")
        if applied is None:
            return Qos()

        def duration(name: str) -> int | None:
            return self._quantity(applied, name, duration_ns, _DURATIONS, "5ms")

        def literal(name: str) -> str | None:
            value = applied.arguments[name]
            shown = str(getattr(value, "literal", ""))
            return None if not shown or shown.endswith("_UNSAID") else shown

        quality, reliability, liveliness = (
            literal("class"), literal("reliability"), literal("liveliness")
        )  # fmt: skip
        depth = applied.arguments["depth"]
        if "depth" in applied.written and depth == 0:
            self._findings.error("G0506", applied.span, "a depth of 0 would keep no samples")
        return Qos(
            None if quality is None else QualityClass[quality],
            None if reliability is None else Reliability[reliability],
            duration("deadline"),
            duration("start_by"),
            duration("latency"),
            duration("lifespan"),
            None if liveliness is None else Liveliness[liveliness],
            depth if isinstance(depth, int) and depth > 0 else None,
            self._media(applied),
            self._on_degraded(applied),
        )

    def _on_degraded(self, applied: Applied) -> OnDegraded | None:
        if "on_degraded" not in applied.written:
            return None
        text = applied.text("on_degraded")
        if text in [each.value for each in OnDegraded]:
            return OnDegraded(text)
        message = f"'on_degraded' must be event, fail or failover, not \"{text}\""
        advice = 'write on_degraded="event", on_degraded="fail" or on_degraded="failover"'
        self._findings.error("G0506", applied.span, message, advice)
        return None

    def _media(self, applied: Applied) -> tuple[str, ...] | None:
        if "media" not in applied.written:
            return None
        media = tuple(m.strip() for m in applied.text("media").split("|"))
        for medium in media:
            if medium not in MEDIA:
                self._findings.error(
                    "G0506",
                    applied.span,
                    f"unknown medium '{medium}'",
                    f'media are {", ".join(MEDIA)}, separated by "|"',
                )
                return None
        return media

    def _quantity(
        self,
        applied: Applied,
        name: str,
        read: Callable[[str], _Number | None],
        units: str,
        example: str,
    ) -> _Number | None:
        if name not in applied.written:
            return None
        text = applied.text(name)
        found = read(text)
        if found is None:
            if text.isdecimal() and int(text) > 0:  # the help line shows it with a unit
                example = text + example.lstrip("0123456789")
            self._findings.error(
                "G0506",
                applied.span,
                f"'{name}' needs a positive number and its unit ({units}), not \"{text}\"",
                f'write {name}="{example}"',
            )
        return found
