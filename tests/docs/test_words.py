"""The documents use standard terms: no word of the left column below, but for the exceptions."""

import re
from pathlib import Path

import pytest

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

EXCEPTIONS: dict[str, set[str]] = {}


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
