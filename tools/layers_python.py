"""Allowed imports of Python. The first row that matches a module lists its allowed imports."""

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from layers_rule import Violation

ROOTS = ("codegen", "runtime/python", "generated/python")


@dataclass(frozen=True, slots=True)
class Row:
    """`imports` matches the full dotted names that a module may import, beside the standard
    library."""

    module: re.Pattern[str]
    imports: re.Pattern[str]
    why: str


def _row(module: str, imports: str, why: str) -> Row:
    return Row(re.compile(module), re.compile(imports), why)


def _gidl(*names: str) -> str:
    return r"gidl\.(?:" + "|".join(names) + r")(?:\..*)?"


# The keywords of IDL and the rules of file names, which each later stage may ask for.
_NAMES = (r"syntax\.keywords", r"files\.names")
_COMPILER = "the compiler stands alone: standard library, and jinja2 in targets/emit.py"

ROWS = (
    _row(
        _gidl("model"),
        _gidl("model"),
        "the model has the meaning of a file: it knows neither text nor targets",
    ),
    _row(
        _gidl("diagnostics"),
        _gidl("diagnostics", "model"),
        "diagnostics know places in files, and nothing of what stands there",
    ),
    _row(
        _gidl("syntax"), _gidl("diagnostics", "syntax"), "syntax: text comes first, meaning later"
    ),
    _row(
        _gidl("files"),
        _gidl("diagnostics", "syntax", "files"),
        "files are found, read and parsed before anybody asks what they mean",
    ),
    _row(
        _gidl("resolve"),
        _gidl("diagnostics", "model", "files", "syntax", "resolve"),
        "resolve -> files, syntax, model",
    ),
    _row(
        _gidl("names"),
        _gidl("diagnostics", "model", "names", *_NAMES),
        "names in generated code -> model",
    ),
    _row(_gidl("wire"), _gidl("model", "names", "wire", *_NAMES), "wire layout -> names, model"),
    _row(_gidl("rules"), _gidl("diagnostics", "model", "rules"), "rules -> model"),
    _row(
        r"gidl\.targets\.emit",
        r"jinja2(\..*)?|" + _gidl("targets", "wire", "model"),
        "cli -> emit -> targets",
    ),
    _row(
        _gidl("targets"),
        _gidl("targets", "wire", "names", "model", *_NAMES),
        "targets -> wire, names -> model",
    ),
    _row(r"gidl(\..*)?", r"gidl(\..*)?", _COMPILER),
    _row(
        r"gecos\.wire(\..*)?",
        r"numpy(\..*)?|gecos\.wire(\..*)?",
        "gecos.wire is standard library and numpy",
    ),
    _row(
        r"robcl\.frames(\..*)?",
        r"numpy(\..*)?|gecos\.wire|robcl\.frames(\..*)?",
        "robcl.frames knows gecos.wire and numpy, no generated code",
    ),
    _row(
        r"gecos\.errors",
        r"gecos\.wire(\.enums|\.units)?|gecos_idl\.object_types",
        "gecos.errors stands beside the codec: declared exceptions are generated types",
    ),
    _row(
        r"(robcl|gecos_idl)\.\w+_types",
        r"numpy(\..*)?|gecos\.(wire|errors)|robcl\.frames(\..*)?|(robcl|gecos_idl)\.\w+_types",
        "generated types know the codec, the root of exceptions and hand-written values alone",
    ),
    _row(
        r"gecos\.cli\.plot(\..*)?",
        r"matplotlib(\..*)?|numpy(\..*)?|click(\..*)?|gecos(\..*)?",
        "gecos plot alone draws; matplotlib is not needed by other commands",
    ),
    _row(
        r"gecos\.cli(\..*)?",
        r"click(\..*)?|rich(\..*)?|gecos(\..*)?|gecos_idl\.\w+",
        "the command stands on gecos, with click and rich",
    ),
    _row(
        r"gecos\.dynamic_client\.connect",
        r"gecos(\..*)?|gecos_idl\.(?:broker|\w+_types)",
        "objects of any interface are found through the generated proxy of the broker",
    ),
    _row(
        r"gecos\.dynamic_client(\..*)?",
        r"gecos(\..*)?|gecos_idl\.\w+_types",
        "a dynamic client needs no generated code",
    ),
    _row(
        r"gecos\.builtin_operations",
        r"gecos(\..*)?|gecos_idl\.(?:object|\w+_types)(?:\..*)?",
        "what every object answers is called through the generated proxy of that alone",
    ),
    _row(
        r"gecos(\..*)?",
        # Only type checkers read typing_extensions, and they install it.
        r"numpy(\..*)?|typing_extensions|gecos(\..*)?|gecos_idl\.\w+_types",
        "gecos knows _core and generated types, no robcl, no generated client",
    ),
    _row(
        r"(robcl|gecos_idl)(\..*)?",
        r"numpy(\..*)?|gecos|gecos\.(?!_core|cli).*|robcl(\..*)?|gecos_idl(\..*)?",
        "generated clients and servers know gecos and types, never _core",
    ),
)


def module_of(path: str) -> str:
    """`codegen/gidl/targets/cpp/view.py` -> `gidl.targets.cpp.view`."""
    for root in ROOTS:
        path = path.removeprefix(root + "/")
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def files(tree: Path) -> Iterator[Path]:
    for root in ROOTS:
        for path in sorted((tree / root).rglob("*.py")):
            if "templates" not in path.parts:
                yield path


def imported(path: str, text: str) -> Iterator[tuple[int, str]]:
    """Yields the line and the dotted name of each import, anywhere in the file."""
    package = module_of(path)
    if not path.endswith("/__init__.py"):
        package = package.rpartition(".")[0]
    for node in ast.walk(ast.parse(text, filename=path)):
        if isinstance(node, ast.Import):
            for name in node.names:
                yield node.lineno, name.name
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = package.split(".")
                above = parts[: len(parts) - node.level + 1]
                base = ".".join([*above, base] if base else above)
            for name in node.names:
                yield node.lineno, f"{base}.{name.name}"


def violations(path: str, text: str) -> list[Violation]:
    module = module_of(path)
    row = next((row for row in ROWS if row.module.fullmatch(module)), None)
    if row is None:
        return [
            Violation(
                path,
                1,
                f"module {module} has no row",
                "every package of ours has a row in tools/layers_python.py",
                "move it into a package that has one, or add a row with its reason",
            )
        ]
    found: dict[tuple[int, str], Violation] = {}
    for line, name in imported(path, text):
        if name.partition(".")[0] in sys.stdlib_module_names or _allowed(row, name):
            continue
        whole = name.rpartition(".")[0]
        name = whole if "." in whole else name
        found[line, name] = Violation(
            path,
            line,
            f"{module} imports {name}",
            row.why,
            "pass in what it needs, or move the code to a module that may import it",
        )
    if module.startswith("gecos.") and not module.startswith(_DESCRIBING):
        for line in _described(path, text):
            found[line, ""] = Violation(
                path,
                line,
                f"{module} describes an operation by hand",
                "descriptions of operations are generated from idl/",
                "declare it in idl/gecos and call it through the generated proxy",
            )
    return list(found.values())


# The module with the tables of operations, and the package that makes them from a served model.
_DESCRIBING = ("gecos.interface", "gecos.dynamic_client")


def _described(path: str, text: str) -> Iterator[int]:
    """Yields the lines that make an Operation of gecos.interface."""
    for node in ast.walk(ast.parse(text, filename=path)):
        if isinstance(node, ast.Call):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else node.func
            name = called if isinstance(called, str) else getattr(called, "id", "")
            if name == "Operation":
                yield node.lineno


def _allowed(row: Row, name: str) -> bool:
    # `from gecos.wire import Decoder` gives the name gecos.wire.Decoder. The row may allow this
    # name or the module gecos.wire.
    return bool(row.imports.fullmatch(name) or row.imports.fullmatch(name.rpartition(".")[0]))
