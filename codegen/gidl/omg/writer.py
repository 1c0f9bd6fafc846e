"""The parts that the CORBA and DDS writers share: order, modules, forward declarations, names and
values.

Names of types are absolute, with a leading `::`, so that no other name can hide them. A type that
is used before its declaration gets a forward declaration before its first use.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator

from gidl.diagnostics.findings import Findings
from gidl.files.names import source_stem
from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    ArrayType,
    Attribute,
    Constant,
    EnumDeclaration,
    EnumValue,
    Facts,
    File,
    Interface,
    Location,
    MapType,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    Value,
)
from gidl.syntax.keywords import UNUSED_BY_LOWER, USED_BY_LOWER

# The keywords of IDL. A name that is one of these words is printed with an underscore before it.
_KEYWORDS = frozenset((*USED_BY_LOWER, *UNUSED_BY_LOWER))
_FORWARD = {Struct: "struct", Union: "union", Interface: "interface"}


class OmgWriter(ABC):
    """Writes a model in one dialect of OMG IDL. @pre the model has no errors."""

    dialect: str  # name in messages: "CORBA" or "DDS"
    primitives: dict[str, str]  # keys: names in .gidl; only primitives that the dialect has

    def __init__(self, model: Model, findings: Findings) -> None:
        self._model = model
        self._findings = findings
        self._lines: list[str] = []
        self._modules: tuple[str, ...] = ()  # names of the open modules, outermost first
        self._declared: set[str] = set()  # names declared so far, also by forward declarations
        self._at = Location("", 1, 1)  # location of the declaration that is being written

    def text(self, whole: bool) -> str:
        printed = [f for f in self._model.files if whole or f.asked_for]
        if self._types_in_types(printed):
            return ""
        here = {f.path for f in printed}
        for file in self._model.files:
            if file.path not in here:
                self._declared.update(d.name for d in file.declarations)
        for file in printed:
            self._file(file, here)
        return "\n".join(self._lines) + "\n"

    def _types_in_types(self, files: Iterable[File]) -> bool:
        """Reports type declarations inside structs and unions, which OMG IDL 4.2 does not allow.
        Returns whether there are any."""
        found = False
        for declaration in (d for file in files for d in file.declarations):
            scope = declaration.scope
            if self._model.has(scope) and not isinstance(self._model.find(scope), Interface):
                self._at = declaration.facts.location
                self._cannot(
                    "a type that is declared inside another type",
                    f"declare the inner type before '{scope}'",
                )
                found = True
        return found

    # -- files and modules ---------------------------------------------------------------------

    def _file(self, file: File, here: set[str]) -> None:
        self._lines.append(f"// {file.path} as {self.dialect}: gidl dump")
        for path in file.includes:
            if path not in here and self._anything_in(path):
                self._lines.append(f'#include "{source_stem(path)}.idl"')
        for unit in self._units(file.declarations):
            modules = self._modules_of(unit[-1])
            for needed in self._missing(unit):
                self._enter(self._modules_of(self._model.find(needed)))
                self._forward(needed)
            self._enter(modules)
            self._declared.add(unit[-1].name)
            self._unit(unit)
            self._declared.update(d.name for d in unit)
        self._enter(())

    def _anything_in(self, path: str) -> bool:
        file = next(f for f in self._model.files if f.path == path)
        return any(self._is_written(d) for d in file.declarations)

    def _is_written(self, declaration: AnyDeclaration) -> bool:
        return not isinstance(declaration, AnnotationDeclaration)

    @abstractmethod
    def _units(
        self, declarations: Iterable[AnyDeclaration]
    ) -> Iterator[tuple[AnyDeclaration, ...]]:
        """Yields groups of declarations. The declarations of a group are printed together, in the
        modules that enclose the last declaration of the group."""

    @abstractmethod
    def _unit(self, unit: tuple[AnyDeclaration, ...]) -> None: ...

    def _modules_of(self, declaration: AnyDeclaration) -> tuple[str, ...]:
        return tuple(declaration.scope.split("::")) if declaration.scope else ()

    def _enter(self, wanted: tuple[str, ...]) -> None:
        """Closes and opens modules until exactly the modules `wanted` are open."""
        common = 0
        while (
            common < min(len(wanted), len(self._modules))
            and wanted[common] == self._modules[common]
        ):
            common += 1
        while len(self._modules) > common:
            self._modules = self._modules[:-1]
            self._line("};")
        for name in wanted[common:]:
            self._line(f"module {self._name(name)} {{")
            self._modules = (*self._modules, name)

    def _line(self, text: str, deeper: int = 0) -> None:
        self._lines.append("  " * (len(self._modules) + deeper) + text)

    def _doc(self, facts: Facts, deeper: int = 0) -> None:
        for line in facts.doc.split("\n") if facts.doc else ():
            self._line(f"// {line}".rstrip().rstrip("\\"), deeper)

    def _cannot(self, what: str, *help_lines: str) -> None:
        self._findings.error(
            "G0802", self._at, f"{self.dialect} cannot express {what}", *help_lines
        )

    # -- forward declarations ------------------------------------------------------------------

    def _missing(self, unit: tuple[AnyDeclaration, ...]) -> list[str]:
        """Returns the types that `unit` uses before their declarations, in order."""
        own = {d.name for d in unit}
        used = (name for d in unit for name in self._used_by(d))
        return list(dict.fromkeys(n for n in used if n not in self._declared and n not in own))

    def _forward(self, name: str, deeper: int = 0) -> None:
        declaration = self._model.find(name)
        kind = next(word for made, word in _FORWARD.items() if isinstance(declaration, made))
        self._declared.add(name)
        self._line(f"{kind} {self._name(declaration.simple_name)};", deeper)

    def _used_by(self, declaration: AnyDeclaration) -> Iterator[str]:
        for used in _types_of(declaration):
            yield from _names_in(used)

    # -- names, types, values ------------------------------------------------------------------

    def _name(self, name: str) -> str:
        return f"_{name}" if name.lower() in _KEYWORDS else name

    def _full(self, scoped: str) -> str:
        return "::" + "::".join(self._name(part) for part in scoped.split("::"))

    def _type(self, used: Type) -> str:
        """Returns the text of a type. For an array, this is the text of the element type, because
        the dimensions follow the name of the member."""
        match used:
            case PrimitiveType(kind):
                written = self.primitives.get(kind.value)
                if written is None:
                    self._cannot(f"{kind.value}")
                return written or kind.value
            case StringType(bound):
                return "string" if bound is None else f"string<{bound}>"
            case SequenceType(element, bound):
                inner = self._type(element)
                space = " " if inner.startswith("::") else ""
                end = " " if inner.endswith(">") else ""
                return f"sequence<{space}{inner}{'' if bound is None else f', {bound}'}{end}>"
            case ArrayType(element):
                return self._type(element)
            case MapType():
                self._cannot("a map", "use a sequence of structs with a key and a value")
                return "octet"
            case NamedType(name):
                return self._full(name)

    def _declarator(self, name: str, used: Type) -> str:
        sizes = used.dimensions if isinstance(used, ArrayType) else ()
        return self._name(name) + "".join(f"[{size}]" for size in sizes)

    def _value(self, value: Value, used: Type) -> str:
        match value:
            case bool():
                return "TRUE" if value else "FALSE"
            case EnumValue(enum, literal):
                scope = enum.rpartition("::")[0]
                return self._full(f"{scope}::{literal}" if scope else literal)
            case int():
                target = self._model.target(used)
                lowest = isinstance(target, PrimitiveType) and value < 0 and (
                    value == target.kind.integer_limits[0]
                )  # fmt: skip
                return f"{value // 2} * 2" if lowest else str(value)
            case float():
                return repr(value)
            case str():
                target = self._model.target(used)
                if target == PrimitiveType(Primitive.CHAR):
                    return f"'{_escaped(value.encode('latin-1'))}'"
                return f'"{_escaped(value.encode())}"'

    def _enum(self, enum: EnumDeclaration, deeper: int, items: list[str]) -> None:
        self._line(f"enum {self._name(enum.simple_name)} {{ {', '.join(items)} }};", deeper)

    def _typedef(self, typedef: Typedef, deeper: int) -> None:
        declarator = self._declarator(typedef.simple_name, typedef.type)
        self._line(f"typedef {self._type(typedef.type)} {declarator};", deeper)

    def _constant(self, constant: Constant, deeper: int) -> None:
        value = self._value(constant.value, constant.type)
        name = self._name(constant.simple_name)
        self._line(f"const {self._type(constant.type)} {name} = {value};", deeper)

    def _labels(self, union: Union, labels: tuple[Value, ...], is_default: bool) -> str:
        written = [f"case {self._value(v, union.discriminator)}:" for v in labels]
        return " ".join([*written, *(["default:"] if is_default else [])])


def _types_of(declaration: AnyDeclaration) -> Iterator[Type]:
    match declaration:
        case Struct():
            yield from (m.type for m in declaration.members)
        case Union():
            yield declaration.discriminator
            yield from (c.member.type for c in declaration.cases)
        case Typedef() | Constant():
            yield declaration.type
        case Interface():
            for member in declaration.members:
                if isinstance(member, Attribute):
                    yield member.type
                    continue
                yield from (p.type for p in member.parameters)
                if member.result is not None:
                    yield member.result


def _names_in(used: Type) -> Iterator[str]:
    match used:
        case NamedType(name):
            yield name
        case SequenceType(element=element) | ArrayType(element=element):
            yield from _names_in(element)
        case MapType(key, value):
            yield from _names_in(key)
            yield from _names_in(value)


_PLAIN = re.compile(rb"[ !#-&(-\[\]-~]")


def _escaped(text: bytes) -> str:
    """Returns `text` with special characters as octal escapes. Each escape has three digits, so
    that a digit after the escape does not become part of it."""
    return "".join(chr(byte) if _PLAIN.match(bytes([byte])) else f"\\{byte:03o}" for byte in text)
