"""Scopes: where names are declared, and how the declaration of a name is found.

Identifiers in one scope must not differ only in case. They must not have the name of a type that is
used in the scope, as in `attribute Frame frame`. The IDL standard has these rules, and every CORBA
compiler enforces them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches

from gidl.diagnostics.findings import Findings, Note, suggestion
from gidl.diagnostics.source import Span
from gidl.model import Type, Value
from gidl.syntax.tree import Name, ScopedName

# A declaration must not have the name of the scope that directly contains it. Scopes of these kinds
# are exempt from this rule.
_UNNAMED = frozenset(("file", "operation", "annotation"))

_MEMBERS = frozenset(("operation", "attribute"))

TYPE_KINDS = frozenset(
    ("struct", "union", "enum", "bitmask", "bitset", "typedef", "interface", "exception")
)


# If the declared type of a value is an interface, the value has the type ObjectRef. The first
# constant is the scoped name of ObjectRef, the second the name of the file that declares ObjectRef.
_OBJECT_REF = "gecos::ObjectRef"
_OBJECT_REF_FILE = "object_ref.gidl"

# Maps the names of types in other languages to their names in IDL.
_ELSEWHERE = {
    "int": "int32", "uint": "uint32", "bool": "boolean", "byte": "octet", "float32": "float",
    "float64": "double", "real": "double", "str": "string", "size_t": "uint64",
    "int8_t": "int8", "int16_t": "int16", "int32_t": "int32", "int64_t": "int64",
    "uint8_t": "uint8", "uint16_t": "uint16", "uint32_t": "uint32", "uint64_t": "uint64",
}  # fmt: skip

# Names of built-in types, which errors suggest for misspelled types.
_BUILT_IN = (
    "boolean", "char", "double", "float", "int16", "int32", "int64", "int8", "long", "map",
    "octet", "sequence", "short", "string", "uint16", "uint32", "uint64", "uint8", "unsigned",
    "wchar", "wstring",
)  # fmt: skip


@dataclass(slots=True, eq=False)
class Symbol:
    name: str  # unscoped name, as declared
    scoped: str
    kind: str  # one of TYPE_KINDS, or "module", "constant", "operation", "member", ...
    span: Span
    file: str
    completed_in: str = ""  # file of the full declaration; "": only declared forward so far
    scope: Scope | None = None  # scope of declarations inside this one
    type: Type | None = None  # type of a constant
    value: Value | None = None  # value of a constant, enumerator or flag
    meanings: tuple[Symbol, ...] = ()  # for kind "ambiguous": the declarations in the bases


@dataclass(slots=True, eq=False)
class Scope:
    name: str  # scoped name, "" at the top level
    kind: str
    parent: Scope | None = None
    symbols: dict[str, Symbol] = field(default_factory=dict)  # key: lower-case name
    uses: dict[str, tuple[str, Span]] = field(default_factory=dict)  # names used from outer scopes
    bases: list[Scope] = field(default_factory=list)  # bases of an interface

    def qualified(self, simple: str) -> str:
        return f"{self.name}::{simple}" if self.name else simple

    def chain(self) -> Iterator[Scope]:
        """Yields this scope and the enclosing scopes, innermost first."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent


class Names:
    """Declares and looks up names. `visible` has the path of the current file and the paths of its
    includes."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self.top = Scope("", "file")
        self.visible: set[str] = set()
        self.forwards: list[tuple[Symbol, Span]] = []  # forward declarations, and their places
        self.declared_here: dict[str, int] = {}  # name declared in the current file -> line
        self.cut: list[str] = []  # includes that are read after the current file
        self.lacks_includes = False  # True: an included file was not found

    # -- declaring -----------------------------------------------------------------------------

    def declare(self, scope: Scope, name: Name, kind: str) -> Symbol | None:
        """Declares `name` and returns its symbol. If the name is taken, adds a finding and returns
        None."""
        key = name.text.lower()
        if key == scope.name.rpartition("::")[2].lower() and scope.kind not in _UNNAMED:
            self._findings.error(
                "G0109",
                name.span,
                f"{kind} '{name.text}' has the name of its enclosing {scope.kind}",
                "a declaration directly in a scope cannot have the name of the scope: rename "
                "the declaration or the scope",
            )
        if scope.qualified(name.text) == _OBJECT_REF and not _file(name).endswith(_OBJECT_REF_FILE):
            self._findings.error(
                "G0101",
                name.span,
                f"'{_OBJECT_REF}' is the type of references to objects, which gidl itself declares",
                f"rename the {kind}, or declare it in a module of your own",
            )
        known = scope.symbols.get(key)
        if known is not None and known.kind == "broken":
            known = None
        if known is not None and not self._may_redeclare(known, name, kind):
            self._clash(known, name, kind)
            return None
        used = scope.uses.get(key)
        if used is not None and known is None:
            self._findings.error(
                "G0105",
                name.span,
                f"{kind} '{name.text}' clashes with the type name '{used[0]}' used in the same "
                "scope: names are compared without regard to case",
                f"rename the {kind}, or write the type with its module: "
                f"'{self._with_module(scope, used)}'",
                notes=(Note("used here", used[1].location),),
            )
        if known is not None:
            known.completed_in = known.completed_in or _file(name)
            known.span = name.span
            return known
        file = _file(name)
        symbol = Symbol(name.text, scope.qualified(name.text), kind, name.span, file, file)
        scope.symbols[key] = symbol
        return symbol

    def poison(self, scope: Scope, name: Name) -> None:
        """Declares the name of a declaration that .gidl does not support. The declaration is
        already reported, so uses of its name must not be reported as unknown."""
        symbol = Symbol(name.text, scope.qualified(name.text), "broken", name.span, _file(name))
        symbol.completed_in = symbol.file
        scope.symbols.setdefault(name.text.lower(), symbol)

    def forward(self, scope: Scope, name: Name, kind: str) -> None:
        known = scope.symbols.get(name.text.lower())
        if known is None:
            known = Symbol(name.text, scope.qualified(name.text), kind, name.span, _file(name))
            scope.symbols[name.text.lower()] = known
        elif known.kind != kind or known.name != name.text:
            if known.kind != "broken":
                self._clash(known, name, kind)
            return
        self.forwards.append((known, name.span))

    def _may_redeclare(self, known: Symbol, name: Name, kind: str) -> bool:
        if known.name != name.text or known.kind != kind:
            return False
        return kind == "module" or not known.completed_in

    def _clash(self, known: Symbol, name: Name, kind: str) -> None:
        note = Note("first declared here", known.span.location)
        if known.name == name.text:
            self._findings.error(
                "G0101",
                name.span,
                f"'{name.text}' is already declared as {_a(known.kind)}",
                _overload_help(known.kind, kind) or "rename one of the two declarations",
                notes=(note,),
            )
        else:
            self._findings.error(
                "G0103",
                name.span,
                f"'{name.text}' differs from '{known.name}' only in case",
                "names are compared without regard to case: rename one of the two declarations",
                notes=(note,),
            )

    def _with_module(self, scope: Scope, used: tuple[str, Span]) -> str:
        for outer in scope.chain():
            symbol = outer.symbols.get(used[0].lower())
            if symbol is not None and symbol.kind in TYPE_KINDS:
                return symbol.scoped if outer.name else f"::{symbol.scoped}"
        return used[0]

    # -- looking up ----------------------------------------------------------------------------

    def look_up(self, name: ScopedName, scope: Scope) -> Symbol | None:
        """Returns the symbol that `name` refers to in `scope`, or None. Reports no finding."""
        path = self.path(name, scope)
        return path[-1] if path else None

    def path(self, name: ScopedName, scope: Scope) -> list[Symbol]:
        """Returns one symbol for each part of `name`, looked up in `scope`. If a part has no
        symbol, returns an empty list and adds no finding. If a part is ambiguous, or its
        declaration had an error, the list ends with this part."""
        symbol = self._first(name, scope)
        path: list[Symbol] = []
        for part in name.parts[1:]:
            if symbol is None:
                return []
            path.append(symbol)
            if symbol.kind in ("broken", "ambiguous"):
                return path
            symbol = None if symbol.scope is None else self._in(symbol.scope, part)
        return [] if symbol is None else [*path, symbol]

    def _first(self, name: ScopedName, scope: Scope) -> Symbol | None:
        first = name.parts[0]
        if name.absolute:
            return self._in(self.top, first)
        for outer in scope.chain():
            symbol = self._in(outer, first)
            if symbol is not None:
                if outer is not scope:
                    scope.uses.setdefault(first.lower(), (first, name.span))
                return symbol
        return None

    def declared(self, scoped: str) -> Symbol | None:
        """Finds a symbol by its scoped name, even if the file of the symbol is not included."""
        scope: Scope | None = self.top
        symbol = None
        for part in scoped.split("::"):
            symbol = None if scope is None else scope.symbols.get(part.lower())
            scope = None if symbol is None else symbol.scope
        return symbol

    def is_complete(self, symbol: Symbol) -> bool:
        """Returns whether the full declaration of `symbol` is visible in the current file."""
        return symbol.completed_in in self.visible

    def check_spelling(self, name: ScopedName, path: Sequence[Symbol]) -> None:
        """Reports each part of a name that differs from its declaration in case."""
        declared = tuple(symbol.name for symbol in path)
        for part, symbol in zip(name.parts, path, strict=False):
            if symbol.name != part:
                self._findings.error(
                    "G0103",
                    name.span,
                    f"'{part}' differs from '{symbol.name}' only in case",
                    f"write '{ScopedName(declared, name.absolute, name.span)}'",
                    notes=(Note("declared here", symbol.span.location),),
                )
                return

    def hidden(self, name: ScopedName, scope: Scope, kinds: frozenset[str]) -> Symbol | None:
        """Returns the symbol called `name` from the nearest scope that declares a symbol with this
        name and one of the kinds `kinds`. A normal look-up may not find this symbol, because a
        symbol of another kind in a nearer scope hides it. Returns None if there is no such
        symbol."""
        for outer in scope.chain():
            symbol = self._in(outer, name.parts[0])
            if len(name.parts) == 1 and symbol is not None and symbol.kind in kinds:
                return symbol
        return None

    def _in(self, scope: Scope, part: str) -> Symbol | None:
        symbol = scope.symbols.get(part.lower())
        if symbol is not None and (symbol.kind == "module" or symbol.file in self.visible):
            return symbol
        found = list(self._inherited(scope, part.lower(), set()))
        if len(found) < 2:
            return found[0] if found else None
        one = found[0]
        return Symbol(one.name, one.scoped, "ambiguous", one.span, one.file, meanings=tuple(found))

    def _inherited(self, scope: Scope, key: str, seen: set[str]) -> Iterator[Symbol]:
        """Yields the declarations with the name `key` (in lower case) in the bases of `scope`. A
        declaration in a base hides the declarations in the bases of this base."""
        for base in scope.bases:
            if base.name in seen:
                continue
            seen.add(base.name)
            own = base.symbols.get(key)
            if own is None or own.file not in self.visible or own.kind in _MEMBERS:
                yield from self._inherited(base, key, seen)
            else:
                yield own

    # -- suggestions ---------------------------------------------------------------------------

    def hint(self, name: ScopedName, scope: Scope, kinds: frozenset[str]) -> str:
        """Returns a help line for an unknown name, or ""."""
        wanted = name.parts[-1]
        if len(name.parts) == 1 and kinds is TYPE_KINDS and wanted in _ELSEWHERE:
            return f"write '{_ELSEWHERE[wanted]}'"
        below = self.declared_here.get(wanted, 0)
        if below > name.span.location.line:
            return (
                f"the name is declared below, in line {below}: IDL requires the declaration before "
                "the use"
            )
        hidden = [
            s for s in self._everything(self.top) if s.name == wanted and s.file not in self.visible
        ]
        if hidden:
            return (
                f"'{hidden[0].scoped}' is declared in {hidden[0].file}, which is not included: "
                f'#include "{hidden[0].file}"'
            )
        known: dict[str, str] = {}
        for symbol in self._everything(self.top):
            if symbol.kind in kinds:
                exact = symbol.name == wanted
                place = f"{symbol.file}:{symbol.span.location.line}"
                if exact:
                    return f"there is '{symbol.scoped}', declared in {place}"
                shown = symbol.name if self._reaches(symbol, scope) else symbol.scoped
                known[shown] = place if symbol.file in self.visible else f"{place} (not included)"
        if close := suggestion(wanted, known):
            return close
        if len(name.parts) == 1 and kinds is TYPE_KINDS:
            built_in = get_close_matches(wanted.lower(), _BUILT_IN, n=1, cutoff=0.75)
            if built_in:
                return f"did you mean '{built_in[0]}'?"
        if self.cut:
            return (
                f"{self.cut[0]} includes this file, so gidl reads {self.cut[0]} after this file: "
                "move the declarations that both files need into a third file"
            )
        return ""

    def _reaches(self, symbol: Symbol, scope: Scope) -> bool:
        around = symbol.scoped.rpartition("::")[0]
        return any(outer.name == around for outer in scope.chain())

    def _everything(self, scope: Scope) -> Iterator[Symbol]:
        for symbol in scope.symbols.values():
            yield symbol
            if symbol.scope is not None:
                yield from self._everything(symbol.scope)

    def incomplete(self) -> Iterator[Symbol]:
        return (s for s in self._everything(self.top) if not s.completed_in)


def _file(name: Name) -> str:
    return name.span.source.path


def _overload_help(known: str, new: str) -> str:
    if known == new == "operation":
        return "IDL has no overloading: give each operation a name of its own"
    if known == "enumerator" or new == "enumerator":
        return "an enumerator is declared in the scope around its enum, not inside the enum"
    return ""


def _a(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeio" else f"a {kind}"
