"""The annotations that gidl knows. Checks the arguments of each use, and the kind of declaration
that the use annotates.

The parameters come from idl/gecos/annotations.gidl. IDL cannot express which declarations an
annotation may annotate, so annotation_places.py lists them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

from gidl.diagnostics.findings import Findings, Note
from gidl.diagnostics.source import Span
from gidl.model import Primitive, PrimitiveType, StringType, Type, Value
from gidl.resolve.constants import Computed, computed, describe_kind, refuse_arithmetic
from gidl.syntax.annotation_places import PLACES
from gidl.syntax.tree import AnnotationUse

# Annotations of the IDL standard that have no meaning in .gidl. gidl never reports them as
# misspelled.
_STANDARD = frozenset(
    [
        "ami",
        "autoid",
        "external",
        "extensibility",
        "ignore_literal_names",
        "key",
        "must_understand",
        "nested",
        "default_nested",
        "non_serialized",
        "oneway",
        "service",
        "topic",
        "try_construct",
        "verbatim",
        "data_representation",
        "hashid",
    ]
)

# Annotations that may be written several times on one declaration.
_REPEATABLE = frozenset(("verbatim",))


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    type: Type | None  # None: the type `any`
    default: Value | None
    literals: Mapping[str, Value] = field(default_factory=dict)  # enumerators by name


@dataclass(frozen=True, slots=True)
class Declared:
    """An annotation declared with @annotation."""

    name: str
    parameters: tuple[Parameter, ...]
    span: Span
    is_ours: bool


@dataclass(frozen=True, slots=True)
class Applied:
    """One use of an annotation. All arguments have a value; an argument that is not written has its
    default."""

    name: str
    arguments: Mapping[str, Value]
    written: frozenset[str]  # names of the arguments that were written
    span: Span
    arithmetic: frozenset[str] = frozenset()  # names of the arguments such as 1 / 2

    def text(self, name: str = "value") -> str:
        return str(self.arguments.get(name, ""))

    def computed(self, name: str = "value") -> Computed:
        return replace(computed(self.arguments[name]), is_arithmetic=name in self.arithmetic)


class Vocabulary:
    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._declared: dict[str, Declared] = {}  # by scoped name in lower case
        self._warned: set[str] = set()

    def add(self, declared: Declared) -> None:
        known = self._declared.get(declared.name.lower())
        if known is not None:
            self._findings.error(
                "G0101",
                declared.span,
                f"annotation '@{declared.name}' is already declared",
                notes=(Note("first declared here", known.span.location),),
            )
            return
        self._declared[declared.name.lower()] = declared

    def find(self, name: str, scopes: list[str]) -> Declared | None:
        """Returns the annotation that `name` means in the scopes `scopes`, which are ordered from
        the innermost to the outermost. Returns None if there is no such annotation."""
        for scope in scopes:
            found = self._declared.get(f"{scope}::{name}".lower() if scope else name.lower())
            if found is not None:
                return found
        return None

    # -- one use -------------------------------------------------------------------------------

    def unknown(self, use: AnnotationUse) -> None:
        """Reports an undeclared annotation: an error if the name looks misspelt, else a warning."""
        name = str(use.name).removeprefix("::")
        if name.lower() in PLACES:
            self._findings.error("G0501", use.span, f"'@{name}' must be written '@{name.lower()}'")
            return
        close = get_close_matches(name.lower(), list(PLACES), n=1, cutoff=0.75)
        close = close or [known for known in PLACES if _two_are_swapped(name.lower(), known)]
        if close and name not in _STANDARD:
            self._findings.error(
                "G0501",
                use.span,
                f"unknown annotation '@{name}'",
                f"did you mean '@{close[0]}'?",
            )
        elif name not in self._warned:
            self._warned.add(name)
            self._findings.warning(
                "G0703",
                use.span,
                f"annotation '@{name}' has no meaning in .gidl; the model keeps it",
                "reported once per run",
            )

    def bind(
        self, use: AnnotationUse, declared: Declared, given: list[tuple[str | None, Computed, Span]]
    ) -> Applied | None:
        """Matches arguments with parameters. If an argument does not fit, adds a finding and
        returns None."""
        parameters = {p.name: p for p in declared.parameters}
        if len(parameters) == 1 and len(given) > 1:
            message = f"'@{declared.name}' takes exactly one argument"
            self._findings.error("G0503", given[1][2], message, f"write {_example(declared)}")
            return None
        arguments: dict[str, Value] = {}
        arithmetic: set[str] = set()
        for name, value, span in given:
            parameter = self._parameter(name, parameters, declared, span)
            if parameter is None:
                return None
            if parameter.name in arguments:
                self._findings.error(
                    "G0503", span, f"'{parameter.name}' of '@{declared.name}' is given twice"
                )
                return None
            fitted = self._fit(value, parameter, declared, span)
            if fitted is None:
                return None
            arguments[parameter.name] = fitted
            if value.is_arithmetic:
                arithmetic.add(parameter.name)
        written = frozenset(arguments)
        for parameter in declared.parameters:
            if parameter.name in arguments:
                continue
            if parameter.default is None:
                self._findings.error(
                    "G0503",
                    use.span,
                    f"'@{declared.name}' needs a value for '{parameter.name}'",
                    f"write {_example(declared)}",
                )
                return None
            arguments[parameter.name] = parameter.default
        return Applied(declared.name, arguments, written, use.span, frozenset(arithmetic))

    def _parameter(
        self, name: str | None, parameters: dict[str, Parameter], declared: Declared, span: Span
    ) -> Parameter | None:
        if name is None:
            if len(parameters) == 1:
                return next(iter(parameters.values()))
            help_line = f"write {_example(declared)}"
            message = f"'@{declared.name}' takes no arguments"
            if parameters:
                message = (
                    f"'@{declared.name}' has several parameters: write the name of the parameter"
                )
            self._findings.error("G0503", span, message, help_line)
            return None
        if name in parameters:
            return parameters[name]
        self.report_parameter(name, declared, span)
        return None

    def report_parameter(self, name: str, declared: Declared, span: Span) -> None:
        """Reports an argument for a parameter that `declared` does not have."""
        parameters = [p.name for p in declared.parameters]
        close = get_close_matches(name, parameters, n=1, cutoff=0.6)
        known = ", ".join(f"'{p}'" for p in parameters)
        hint = (
            f"did you mean '{close[0]}'?"
            if close
            else f"the annotation has {known or 'no parameters'}"
        )
        self._findings.error("G0503", span, f"'@{declared.name}' has no parameter '{name}'", hint)

    def _fit(
        self, given: Computed, parameter: Parameter, declared: Declared, span: Span
    ) -> Value | None:
        if parameter.type is None:
            return given.value
        wanted, fits = _wanted(parameter, given)
        if fits:
            if isinstance(given.value, int) and wanted == "a floating-point number":
                refused = refuse_arithmetic(given, span, self._findings)
                return None if refused else float(given.value)
            return given.value
        hint = ""
        if given.value in parameter.literals:
            hint = f"write it without quotes: {parameter.name}={given.value}"
        elif parameter.literals:
            hint = value_hint([parameter], "")
        elif isinstance(parameter.type, StringType):
            single = len(declared.parameters) == 1
            shown_use = _example(declared) if single else f'{parameter.name}="..."'
            hint = f"write it in quotes: {shown_use}"
        shown = str(given.value) if given.kind == "int" else describe_kind(given.kind)
        message = f"'{parameter.name}' of '@{declared.name}' must be {wanted}, not {shown}"
        self._findings.error("G0503", span, message, hint)
        return None

    # -- placement -----------------------------------------------------------------------------

    def check_place(self, applied: Applied, place: str) -> bool:
        allowed = PLACES.get(applied.name)
        if allowed is None or place in allowed:
            return True
        shown = ", ".join(sorted(_plural(p) for p in allowed))
        self._findings.error(
            "G0504",
            applied.span,
            f"'@{applied.name}' cannot annotate {_article(place)}",
            f"it applies to {shown}",
        )
        return False

    def check_repeated(self, applied: Applied, first: Applied | None) -> bool:
        if first is None or applied.name in _REPEATABLE:
            return True
        self._findings.error(
            "G0505",
            applied.span,
            f"'@{applied.name}' is written twice",
            notes=(Note("first written here", first.span.location),),
        )
        return False


def _wanted(parameter: Parameter, given: Computed) -> tuple[str, bool]:
    """Returns the expected type of the parameter in words, and whether the value has this type."""
    match parameter.type:
        case StringType(bound):
            what = "a string" if bound is None else f"a string of at most {bound} bytes"
            short = bound is None or len(str(given.value).encode()) <= bound
            return what, given.kind == "string" and short
        case PrimitiveType(Primitive.BOOLEAN):
            return "a boolean, TRUE or FALSE", given.kind == "bool"
        case PrimitiveType(Primitive.CHAR):
            return "a character", given.kind == "char"
        case PrimitiveType(kind) if kind.is_floating:
            return "a floating-point number", given.kind in ("int", "float")
        case PrimitiveType(kind):
            low, high = kind.integer_limits
            fits = isinstance(given.value, int) and given.kind == "int"
            return f"an integer from {low} to {high}", fits and low <= int(str(given.value)) <= high
        case _:
            fits = given.kind == "enum" and given.value in parameter.literals.values()
            return "an enumerator", fits


def _two_are_swapped(name: str, known: str) -> bool:
    """Returns whether `name` becomes `known` when two adjacent letters are swapped."""
    return any(
        f"{name[:at]}{name[at + 1]}{name[at]}{name[at + 2 :]}" == known
        for at in range(len(name) - 1)
    )


def value_hint(meant: Sequence[Parameter], name: str) -> str:
    """Returns a help line for the unknown name `name` in an argument of an annotation. `meant` are
    the parameters to which the argument may belong. The line says what to write; it is empty if
    every constant is allowed there."""
    literals = [each for p in meant for each in p.literals if not each.endswith("_UNSAID")]
    if literals:
        return f"one of {', '.join(literals)}"
    if len(meant) == 1 and isinstance(meant[0].type, StringType):
        return f'write it in quotes: {meant[0].name}="{name}"'
    return ""


def _example(declared: Declared) -> str:
    """Returns an annotation with example arguments, in the syntax of .gidl."""
    if not declared.parameters:
        return f"@{declared.name}"
    if len(declared.parameters) == 1:
        return f"@{declared.name}({_value_example(declared.parameters[0])})"
    shown = ", ".join(f"{p.name}={_value_example(p, '...')}" for p in declared.parameters[:3])
    return f"@{declared.name}({shown}{', ...' if len(declared.parameters) > 3 else ''})"


def _value_example(parameter: Parameter, number: str = "1") -> str:
    if parameter.literals:
        return list(parameter.literals)[-1]
    match parameter.type:
        case StringType():
            return '"..."'
        case PrimitiveType(Primitive.BOOLEAN):
            return "TRUE"
        case _:
            return number


def _article(place: str) -> str:
    return f"an {place}" if place[0] in "aeiou" else f"a {place}"


def _plural(place: str) -> str:
    return f"{place}es" if place.endswith(("s", "x")) else f"{place}s"
