"""Documents and identifiers use standard terms, except for the uses with a stated reason."""

import re
from pathlib import Path

import private_terms
import pytest
from private_terms import Use, all_uses, allow_list, uses_in

TREE = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted(
    [
        TREE / "README.md",
        TREE / "CONTRIBUTING.md",
        *TREE.glob("docs/**/*.md"),
        *TREE.glob("[a-z]*/README.md"),
    ]
)

INSTEAD = {  # as whole words, in the plural too
    "adrift": "waits for failover",
    "baton": "leader lock",
    "bell": "event descriptor",
    "cast off": "detach",
    "door": "acceptor",
    "farewell": "shutdown",
    "glance": "poll once",
    "guest": "pending peer",
    "heir": "the session in which it is resumed",
    "housekeeping": "maintenance",
    "lineage": "fork generation",
    "mended": "corrected",
    "moor": "attach",
    "outlet": "sealed sender",
    "overtake": "start before, or reorder",
    "overtaken": "reordered",
    "poke": "notify",
    "stood still": "was suspended",
    "suspect": "dead candidate",
    "tended": "with a tick",
    "what travels": "the encoding",
    "whoever": "the one who, with a noun",
}

EXCEPTIONS: dict[str, set[str]] = {  # doors of rooms, whose contacts report to a zone
    "docs/decisions/0061-a-zone-reports-and-silence-is-absence.md": {"door"},
    "docs/decisions/0062-an-edit-moves-an-object-into-a-zone.md": {"door"},
    "docs/glossary.md": {"door"},
    "docs/security.md": {"door"},
}


def prose_of(document: Path) -> str:
    """Without code, in blocks or in lines, and without the addresses of links."""
    text = document.read_text(encoding="utf-8")
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]*`|\]\([^)\n]*\)", "", text)


def private_words(document: Path) -> set[str]:
    prose = prose_of(document)
    return {word for word in INSTEAD if re.search(rf"\b{word}s?\b", prose, re.IGNORECASE)}


def name(document: Path) -> str:
    return document.relative_to(TREE).as_posix()


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_no_private_term_is_left(document: Path) -> None:
    allowed = EXCEPTIONS.get(name(document), set())
    found = private_words(document)
    assert {word: INSTEAD[word] for word in found - allowed} == {}
    assert allowed - found == set(), "an exception that nobody needs any more"


def test_a_private_term_is_seen_in_prose_and_not_in_code(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("Take the `door`, [here](door.md).\n```text\ndoor\n```\n")
    assert private_words(page) == set()
    page.write_text("Several Doors.\n")
    assert private_words(page) == {"door"}


def test_no_identifier_has_a_private_term() -> None:
    allowed = allow_list()
    left = sorted(use for use in all_uses() if not any(each.covers(use) for each in allowed))
    assert [
        f"{use.file}: {use.identifier}: {private_terms.INSTEAD[use.term]}" for use in left
    ] == []


def test_every_use_that_stays_has_a_reason_and_exists() -> None:
    assert [each.term for each in allow_list() if len(each.reason) < 5] == []
    unused = [each for each in allow_list() if not any(each.covers(use) for use in all_uses())]
    assert unused == [], "an exception that nobody needs any more"


def test_a_private_term_is_seen_in_identifiers_and_not_in_comments_or_texts() -> None:
    file = "devices/x.cpp"
    quiet = '// door\n/* a\n door */ say("a \\"door\\" here"); indoors();'
    assert uses_in(file, quiet) == set()
    for identifier in ("door", "open_doors_", "HandshakeDoor", "DOOR"):
        assert uses_in(file, f"auto x = {identifier};") == {Use(file, identifier, "door")}
    assert uses_in(file, "all_up_to_") == {Use(file, "all_up_to_", "all up to")}
    assert uses_in("devices/x.py", '"""door"""\nx = "door"  # door\n') == set()
