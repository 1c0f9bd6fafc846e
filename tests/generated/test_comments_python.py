"""Any comment becomes a docstring that parses and says what the author wrote."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from generating import generate

COMMENTS = {
    "quote": 'ends in a quote "',
    "quotes": 'ends in two ""',
    "triple": '"""three""" and four """" of them',
    "ends_in_triple": 'says """three more"""',
    "starts": '"starts with one',
    "backslash": "ends in a backslash \\",
    "escapes": r"\N{BULLET} \x \u12 \ and \" too",
    "long_word": "see https://example.org/(" + "a" * 150 + ")?x=[1,2,3]&y={z}",
    "long": "goes on, and (on [and {on}]), " * 12,
    "letters": "Grüße — 你好 \u2028 and \ue000 a \ue001 mark \ue002 of \ue003 ours",
    "braces": "{{ not }} {% a %} {# template #}",
    "code": "x = f(1, 2)  # not code",
    "long_quote": "a " * 42 + 'b " c"',
    "at": "@decorated",
    "only": '"',
}


def file() -> str:
    lines = ["#pragma once", "module notes {", "  enum Kinds {"]
    lines += [f"    /// {text}\n    K_{name}," for name, text in COMMENTS.items()]
    lines += ["    K_last };", "  bitmask Flags {"]
    lines += [f"    /// {text}\n    F_{name}," for name, text in COMMENTS.items()]
    lines += ["    F_last };", "  struct Members {"]
    lines += [f"    /// {text}\n    double m_{name};" for name, text in COMMENTS.items()]
    lines += ["  };", "  union Arms switch (long) {"]
    for i, (name, text) in enumerate(COMMENTS.items()):
        lines.append(f"    case {i}:\n    /// {text}\n    double a_{name};")
    lines += ["  };"]
    for name, text in COMMENTS.items():
        lines.append(f"  /// {text}\n  struct S_{name} {{ long x; }};")
        lines.append(f"  /// {text}\n  typedef long T_{name};")
        lines.append(f"  /// {text}\n  const long C_{name} = 1;")
        lines.append(f"  /// {text}\n  exception E_{name} {{ long x; }};")
    lines += ['  @version("1.0") interface Things {']
    for name, text in COMMENTS.items():
        lines.append(f"    /// {text}\n    @deprecated({_literal(text)}) void f_{name}(")
        lines.append(f"      /// {text}\n      in double x);")
        lines.append(f"    /// {text}\n    attribute long v_{name};")
        lines.append(f"    void g_{name}(\n      /// {text}\n      in double x);")
    return "\n".join([*lines, "  };", "};", ""])


def _literal(text: str) -> str:
    safe = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{safe}"'


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("notes")
    (folder / "notes.gidl").write_text(file(), encoding="utf-8")
    generate(folder, folder / "notes.gidl")
    sys.path.insert(0, str(folder / "python"))
    yield folder
    sys.path.remove(str(folder / "python"))


def plain(text: str) -> str:
    """What is left of a comment: its words."""
    kept = "".join(letter for letter in text if not "\ue000" <= letter <= "\ue003")
    return " ".join(kept.split())


def test_docstrings_say_what_the_author_wrote(out: Path) -> None:
    types, calls = import_module("notes_types"), import_module("notes")
    for name, text in COMMENTS.items():
        assert plain(getattr(types, f"S_{name}").__doc__) == plain(text)
        assert plain(getattr(types.Arms, f"a_{name}").__doc__) == plain(text)
        doc = plain(getattr(calls.Things, f"f_{name}").__doc__)
        assert doc.count(plain(text)) == 3, name  # its own, that of its parameter, the reason
        assert plain(getattr(calls.Things, f"g_{name}").__doc__) == f"x: {plain(text)}"


def test_docs_of_members_stand_below_them(out: Path) -> None:
    tree = ast.parse((out / "python" / "notes_types.py").read_text(encoding="utf-8"))
    bodies = {c.name: c.body for c in tree.body if isinstance(c, ast.ClassDef)}
    bodies["module"] = tree.body
    for body, start in (("Kinds", "K_"), ("Flags", "F_"), ("Members", "m_"), ("module", "C_")):
        found = {}
        for each, after in zip(bodies[body], bodies[body][1:], strict=False):
            target = getattr(each, "target", None) or (getattr(each, "targets", None) or [None])[0]
            if isinstance(target, ast.Name) and target.id.startswith(start):
                doc = after.value.value if isinstance(after, ast.Expr) else ""
                found[target.id.removeprefix(start)] = plain(doc)
        for name, text in COMMENTS.items():
            assert found[name] == plain(text), (body, name)
