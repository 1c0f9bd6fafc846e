"""Draws the sheets of a reading test: can a stranger read this code?

The sheet has lines of code without their file, comments, and texts that users meet (errors, log
lines, help). A stranger who has only the list of folders and docs/glossary.md writes for each line
the folder that it belongs to, and for each comment and text whether one reading was enough. The key
has the places. The same seed draws the same sheet from the same tree.

The strict form, which is the default and the one whose figures count, lists the bare names of the
folders. `--contents` prints beside each folder its sentence in docs/architecture.md, as a newcomer
would have it; figures of the two forms cannot be compared.
"""

import argparse
import ast
import random
import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
ROOTS = ("runtime", "codegen", "devices")
LINES, PROSE = 30, 30
WORD = re.compile(r"[A-Za-z_]{4,}")
BLANK = "{…}"
ABOUT_TEXTS = f"""
{BLANK} in a text stands for what the program fills in. Before a text that begins with a verb, the
program prints the name of the object, file or field that the text is about."""
CPP_TEXT = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
# Of `condition ? "text" : "text"`, a reader meets only one.
OTHER_TEXT = re.compile(r'(\?\s*"(?:[^"\\\n]|\\.)*")\s*:\s*"(?:[^"\\\n]|\\.)*"')


@dataclass(frozen=True, slots=True)
class Found:
    place: str  # path:line
    text: str

    @property
    def folder(self) -> str:
        return str(Path(self.place).parent)


def sources() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", *ROOTS], cwd=TREE, capture_output=True, text=True, check=True
    )
    names = [TREE / name for name in listed.stdout.splitlines()]
    return [name for name in names if name.suffix in (".cpp", ".hpp", ".py")]


def folders() -> list[str]:
    return sorted({str(path.relative_to(TREE).parent) for path in sources()})


def says_something(line: str) -> bool:
    """Whether a person could place the line at all: it has three words, and is no import."""
    code = re.sub(r"//.*|\s# .*", "", line).strip()
    imported = re.match(r"#include|import |from |using |namespace |#pragma|@", code)
    return not imported and len(code) >= 30 and len(set(WORD.findall(code))) >= 3


def is_prose(text: str) -> bool:
    """Returns whether `text` has the words of a sentence."""
    return len(WORD.findall(text)) >= 4 and " " in text.strip()


def is_code(text: str) -> bool:
    """Returns whether a string in the source is a line of generated code, which no user reads."""
    return text.rstrip().endswith((";", "{", "}"))


def of_cpp(path: Path) -> Iterator[tuple[str, int, str]]:
    """Kind (line, comment, text), line number and text of all that a C++ file offers."""
    comment: list[str] = []
    texts: list[str] = []  # of the statement so far
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        stripped = line.strip()
        if stripped.startswith("//"):
            comment.append(stripped.lstrip("/").strip())
            continue
        if comment:
            yield "comment", number - len(comment), " ".join(comment)
            comment = []
        if says_something(line):
            yield "line", number, stripped
        texts += CPP_TEXT.findall(OTHER_TEXT.sub(r"\1", line)) if "#include" not in line else []
        if texts and stripped.endswith((";", "{", "}")):
            yield "text", number, BLANK.join(texts)
            texts = []


def no_text(node: ast.AST) -> list[ast.expr]:
    """Strings in `node` that no user reads: lists of names, which are split, and patterns."""
    if not isinstance(node, ast.Call):
        return []
    if isinstance(node.func, ast.Name) and node.func.id == "words":
        return node.args
    if not isinstance(node.func, ast.Attribute):
        return []
    if node.func.attr == "split":
        return [node.func.value]
    in_re = isinstance(node.func.value, ast.Name) and node.func.value.id == "re"
    return node.args[:1] if in_re else []


def of_python(path: Path) -> Iterator[tuple[str, int, str]]:
    source = path.read_text(encoding="utf-8")
    documented: set[int] = set()  # lines of docstrings
    inner: set[int] = set()  # ids of the constant pieces of f-strings, and of what is no text
    for node in ast.walk(ast.parse(source)):  # parents first
        inner.update(map(id, no_text(node)))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            docstring = ast.get_docstring(node)
            if docstring:
                first = node.body[0]
                documented.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
                yield "comment", first.lineno, " ".join(docstring.split())
        elif isinstance(node, ast.JoinedStr):
            inner.update(map(id, node.values))
            pieces = (v.value if isinstance(v, ast.Constant) else BLANK for v in node.values)
            yield "text", node.lineno, "".join(map(str, pieces))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            apart = node.lineno not in documented and id(node) not in inner
            yield from [("text", node.lineno, node.value)] if apart else []
    comment: list[str] = []
    for number, line in enumerate(source.splitlines(), 1):
        stripped = line.strip()
        if stripped.startswith("#"):
            comment.append(stripped.lstrip("# "))
            continue
        if comment:
            yield "comment", number - len(comment), " ".join(comment)
            comment = []
        if number not in documented and says_something(line):
            yield "line", number, stripped


def drawn(seed: int) -> dict[str, list[Found]]:
    found: dict[str, list[Found]] = {"line": [], "comment": [], "text": []}
    for path in sources():
        parts = of_python(path) if path.suffix == ".py" else of_cpp(path)
        for kind, number, text in parts:
            if kind == "line" or (is_prose(text) and not (kind == "text" and is_code(text))):
                found[kind].append(Found(f"{path.relative_to(TREE)}:{number}", text))
    choice = random.Random(seed)
    return {
        kind: choice.sample(each, LINES if kind == "line" else PROSE)
        for kind, each in found.items()
    }


def contents_of_folders(architecture: str) -> dict[str, str]:
    """What docs/architecture.md says of each folder in its first table."""
    table = re.search(r"^\| folder \|.*?\n\n", architecture, re.MULTILINE | re.DOTALL)
    said: dict[str, str] = {}
    row = re.compile(r"^\| `([^` ]+)` \| (.+) \|$", re.MULTILINE)
    for names, contents in row.findall(table[0] if table else ""):
        start, _, alternatives = names.partition("{")
        for each in alternatives.rstrip("}").split(","):
            said[(start + each).rstrip("/")] = contents
    return said


def main() -> None:
    parser = argparse.ArgumentParser(description="draws the sheets of a reading test")
    parser.add_argument("seed", type=int)
    parser.add_argument("--key", action="store_true", help="print the places, not the sheet")
    parser.add_argument("--contents", action="store_true", help="say what is in each folder")
    options = parser.parse_args()
    sheet = drawn(options.seed)
    if options.key:
        for kind, each in sheet.items():
            for at, one in enumerate(each, 1):
                print(f"{kind} {at}: {one.folder if kind == 'line' else one.place}")
        return
    said = (
        contents_of_folders((TREE / "docs/architecture.md").read_text("utf-8"))
        if options.contents
        else {}
    )
    print("Folders:")
    for folder in folders():
        print(f"  {folder}: {said[folder]}" if said else f"  {folder}")
    for kind, each in sheet.items():
        if kind == "text" and each:
            print(ABOUT_TEXTS)
        for at, one in enumerate(each, 1):
            print(f"\n{kind} {at}:\n    {one.text}")


if __name__ == "__main__":
    main()
