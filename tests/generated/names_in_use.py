"""What generated Python modules name themselves and their classes inherit, and interfaces whose
declarations have all of those names."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterable, Iterator
from enum import IntEnum, IntFlag
from pathlib import Path

from gecos.errors import DeclaredError
from gecos.proxy import Object
from gecos.servant import Servant


def names_in_use(modules: Iterable[Path]) -> list[list[str]]:
    """What the modules import for themselves, the builtins and the locals that they name, without
    a leading underscore, sorted. IDL compares without regard to case: what differs in nothing else
    is in another list."""
    found: set[str] = {"self", "cls", "annotations"}
    for base in (IntEnum, IntFlag, BaseException, DeclaredError, Object, Servant):
        found |= {name for name in dir(base) if not name.startswith("_")}
    for module in modules:
        found |= set(_names(ast.parse(module.read_text(encoding="utf-8"))))
    plain = {name.strip("_") for name in found}
    groups: list[list[str]] = []
    for name in sorted(plain, key=lambda n: (n.lower(), n)):
        if not name or not name[0].isalpha():
            continue
        group = next((g for g in groups if name.lower() not in {n.lower() for n in g}), None)
        if group is None:
            groups.append(group := [])
        group.append(name)
    return groups


def _names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.alias(name, asname):
                if asname is not None or name[0].islower():
                    yield name.split(".")[-1]
                    yield (asname or name).split(".")[0]
            case ast.Name(name) if hasattr(builtins, name):
                yield name
            case ast.FunctionDef(name, args) if name != "decode":
                declared = "_Command[" in ast.unparse(node) or "_abstractmethod" in ast.unparse(
                    node
                )
                for each in ast.walk(node):
                    if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store):
                        yield each.id
                if not declared:  # else its parameters are an interface's own
                    yield from (each.arg for each in ast.walk(args) if isinstance(each, ast.arg))


TYPES = """
  @final struct {n} {{ double x; sequence<string> y; }};
  @appendable struct {n} {{ double x; sequence<string> y; }};
  exception {n} {{ double x; sequence<string> y; }};
  enum {n} {{ @default_literal {N}_ONE, {N}_TWO }};
  @bit_bound(8) bitmask {n} {{ {N}_LEFT, {N}_RIGHT }};
  bitset {n} {{ bitfield<3> low; bitfield<9, int16> high; }};
  union {n} switch (long) {{ case 1: double x; case 2: sequence<string> y; }};
""".strip().splitlines()


def types_file(module: str, names: list[str]) -> str:
    """Each name is that of a type, of every kind in turn, which goes through a call."""
    lines = ["#pragma once", f"module {module} {{"]
    for i, name in enumerate(names):
        lines.append(TYPES[i % len(TYPES)].format(n=f"_{name}", N=f"Z{i}"))
    lines.append('  @version("1.0") interface Zall {')
    for i, name in enumerate(names):
        used = f"{module}::_{name}"
        if TYPES[i % len(TYPES)].strip().startswith("exception"):
            lines.append(f"    void f{i}(in double z) raises ({used});")
            continue
        lines.append(f"    {used} f{i}(in {used} z, in sequence<{used}> several);")
        lines.append(f'    @sensor @stream(rate="1Hz") readonly attribute {used} g{i};')
        if " struct " in TYPES[i % len(TYPES)]:
            feedback = f'@cancelable(feedback="{module}::{name}")'
            lines.append(f"    {feedback} void h{i}(@optional in {used} z);")
    return "\n".join([*lines, "  };", "};", ""])


MEMBERS = (
    "double", "sequence<string>", "sequence<octet>", "map<string, Zp>", "Zhue", "Zp", "Zq",
    "sequence<Zp>", "@optional Zq", "Zq", "@range(min=0, max=3) long", "string", "Zp", "boolean",
)  # fmt: skip


def members_file(module: str, names: list[str]) -> str:
    """Each name is that of a parameter, member, arm, field, operation and enumerator."""
    lines = ["#pragma once", f"module {module} {{", "  enum Zhue { @default_literal ZA, ZB };"]
    lines.append("  @appendable struct Zp { double x; string s; Zhue hue; };")
    lines.append("  @final struct Zq { double x; Zhue y; };")
    for kind, name in (("struct", "Zmembers"), ("exception", "Zfailed")):
        lines.append(f"  {kind} {name} {{")
        lines += [f"    {MEMBERS[i % len(MEMBERS)]} _{n};" for i, n in enumerate(names)]
        lines.append("  };")
    lines.append("  union Zarms switch (long) {")
    plain = [m for m in MEMBERS if not m.startswith("@")]
    lines += [f"    case {i}: {plain[i % len(plain)]} _{n};" for i, n in enumerate(names)]
    lines.append("  };")
    for first in range(0, len(names), 60):
        lines.append(f"  bitset Zbits{first} {{")
        lines += [f"    bitfield<1> _{n};" for n in names[first : first + 60]]
        lines.append("  };")
    lines.append('  @version("1.0") interface Zparameters {')
    for i, n in enumerate(names):
        lines.append(
            f"    void f{i}(in double _{n}, in string za, in sequence<Zp> zb, "
            "in sequence<double> zc, in map<string, Zp> zd, in Zhue ze, "
            "@optional in Zq zf, @default(3) in long zg);"
        )
        inout = "inout map<string, double> za, out long zb"
        lines.append(f"    sequence<Zp> g{i}(in sequence<Zp> _{n}, {inout});")
        lines.append(f'    @cancelable(feedback="Zp") void h{i}(in map<Zhue, Zq> _{n});')
    lines += ["  };", '  @version("1.0") interface Zmethods {']
    for i, n in enumerate(names):
        lines.append(f"    sequence<Zp> _{n}(in map<string, octet> za, in Zq zb);")
        lines.append(f'    @sensor @stream(rate="1Hz") readonly attribute sequence<string> z{i};')
    lines += ["  };", "};", f"module {module}_enumerators {{", "  enum Zcolour {"]
    lines += [f"    _{n}," for n in names]
    return "\n".join([*lines, "    ZLAST };", "};", ""])
