"""What the documents name exists."""

import ast
import re
import sys
import tomllib
from collections import Counter
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted([*TREE.glob("*.md"), *TREE.glob("docs/**/*.md"), *TREE.glob("[a-z]*/README.md")])

LINK = re.compile(r"\]\(([^)#\s]+)(#[^)\s]*)?\)")
# A file of ours in backticks: `tools/setup.sh`, `docs/protocol.md`; not one that the reader of the
# page writes: `idl/lab/lift.gidl` with a colon and the file behind it.
QUOTED = re.compile(
    r"`((?:idl|codegen|runtime|devices|generated|examples|tests|benchmarks|docs|cmake|tools)"
    r"/[\w./-]*)`(?!:\n\n```)"
)
TARGET = re.compile(r"\bmake ([a-z][a-z-]*)")


def text_of(document: Path) -> str:
    return document.read_text(encoding="utf-8")


def name(document: Path) -> str:
    return document.relative_to(TREE).as_posix()


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_every_link_leads_somewhere(document: Path) -> None:
    links = [link[1] for link in LINK.finditer(text_of(document)) if "://" not in link[1]]
    assert [link for link in links if not (document.parent / link).exists()] == []


def anchors(document: Path) -> set[str]:
    """The anchors that a reader of Markdown gives to the headings, by GitHub's rule."""
    fenced = re.compile(r"^ *```.*?^ *```", re.DOTALL | re.MULTILINE)
    text = fenced.sub("", text_of(document))
    found: set[str] = set()
    times: Counter[str] = Counter()
    for heading in re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE):
        shown = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", shown).replace(" ", "-")
        found.add(f"{anchor}-{times[anchor]}" if times[anchor] else anchor)
        times[anchor] += 1
    return found


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_every_link_to_a_heading_leads_to_one(document: Path) -> None:
    wrong = []
    for file, anchor in re.findall(r"\]\(([^)#\s]*)#([^)\s]*)\)", text_of(document)):
        place = document.parent / file if file else document
        if "://" not in file and place.suffix == ".md" and anchor not in anchors(place):
            wrong.append(f"{file}#{anchor}")
    assert wrong == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_every_file_in_backticks_exists(document: Path) -> None:
    named = [match[1] for match in QUOTED.finditer(text_of(document))]
    assert [path for path in named if not (TREE / path).exists()] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_every_make_target_exists(document: Path) -> None:
    makefile = text_of(TREE / "Makefile")
    code = re.findall(r"`[^`]+`|```.*?```", text_of(document), flags=re.DOTALL)
    asked = {match[1] for part in code for match in TARGET.finditer(part)}
    assert sorted(x for x in asked if not re.search(rf"^{x}:", makefile, re.MULTILINE)) == []


def test_every_annotation_is_documented() -> None:
    vocabulary = text_of(TREE / "codegen/gidl/include/gecos/annotations.gidl")
    declared = set(re.findall(r"^@annotation (\w+)", vocabulary, re.MULTILINE))
    assert declared
    documented = set(re.findall(r"`@(\w+)", text_of(TREE / "docs/gidl.md")))
    assert declared - documented == set()


def settings_that_are_read() -> set[str]:
    read = re.compile(
        r"""(?:getenv\(|\bset\(|environ\.get\(|environment\(|\$\{)"?((?:GECOS|ROBCL|GIDL|FUZZ|STRESS)_[A-Z_]+)(?:"|:-)"""
    )
    return {
        match[1]
        for folder in ("runtime", "codegen", "tools", "devices", "tests")
        for file in (TREE / folder).rglob("*")
        if file.suffix in (".cpp", ".hpp", ".py", ".sh")
        for match in read.finditer(text_of(file))
    }


def test_every_setting_is_documented_and_every_documented_one_is_read() -> None:
    section = text_of(TREE / "docs/programs.md").split("\n## Settings\n")[1]
    documented = set(re.findall(r"^\| `([A-Z_]+)`", section, re.MULTILINE))
    assert documented == settings_that_are_read()


def test_the_documents_that_visitors_look_for_are_there() -> None:
    present = {name(document) for document in DOCUMENTS}
    assert {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/architecture.md"} <= present


class Imports(ast.NodeVisitor):
    """The packages that a file needs to run."""

    def __init__(self, file: Path) -> None:
        self.packages: set[str] = set()
        self.visit(ast.parse(text_of(file)))

    def visit_Import(self, node: ast.Import) -> None:
        self.packages |= {name.name.partition(".")[0] for name in node.names}

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        if node.level == 0 and node.module:
            self.packages.add(node.module.partition(".")[0])

    def visit_If(self, node: ast.If) -> None:
        if not (isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"):
            self.generic_visit(node)


def packages_of_others(folder: Path) -> set[str]:
    needed = set().union(*(Imports(file).packages for file in folder.rglob("*.py")))
    return needed - sys.stdlib_module_names - {"gecos", "gecos_idl", "robcl"}


def test_what_gecos_imports_is_required_and_documented() -> None:
    project = tomllib.loads(text_of(TREE / "pyproject.toml"))["project"]
    optional = {re.split("[<>=]", each)[0] for each in project["optional-dependencies"]["plot"]}
    all_imported = packages_of_others(TREE / "runtime/python")
    assert optional <= all_imported
    imported = all_imported - optional
    assert {re.split("[<>=]", each)[0] for each in project["dependencies"]} == imported
    command = re.search(r'"gecos:gecos.cli:main:([\w ]+)"', text_of(TREE / "cmake/Package.cmake"))
    assert command and set(command[1].split()) == imported
    sdk = text_of(TREE / "docs/sdk.md")
    assert {name for name in all_imported if f"`{name}`" not in sdk} == set()
    for page in ("docs/ci.md", "docs/deploying.md"):
        (installed,) = re.findall(r"pip install ((?:jinja2 )?numpy[\w ]*)`", text_of(TREE / page))
        assert set(installed.split()) - {"jinja2"} == imported, page


def test_each_picture_of_a_motion_is_small_and_on_a_page() -> None:
    pictures = sorted((TREE / "docs/pictures").iterdir())
    assert pictures
    page = text_of(TREE / "docs/motion.md")
    assert [each.name for each in pictures if f"](pictures/{each.name})" not in page] == []
    assert [each.name for each in pictures if each.stat().st_size > 150_000] == []


def test_systemd_leaves_the_order_of_the_end_to_gecos_up() -> None:
    """Without this line, systemd sends SIGTERM to all programs of the unit at once."""
    units = re.findall(
        r"```ini\n(\[Unit\]\n.*?)```", text_of(TREE / "docs/deploying.md"), re.DOTALL
    )
    of_laboratories = [unit for unit in units if "bin/gecos up" in unit]
    assert of_laboratories
    assert all("\nKillMode=mixed\n" in unit for unit in of_laboratories)
