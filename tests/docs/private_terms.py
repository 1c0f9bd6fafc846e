"""Private terms of the early sources, the standard terms for them, and the identifiers with one.

An identifier is split at underscores and capitals. A term of several words matches consecutive
words.
"""

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
FOLDERS = ("runtime", "devices", "codegen", "tests", "examples", "benchmarks")
SUFFIXES = {".cpp", ".hpp", ".py", ".pyi", ".j2"}

MEDIA = ("runtime/cpp/gecos/media/*", "tests/cpp/media/*", "tests/cpp/session/*", "benchmarks/*")
SESSION = ("runtime/cpp/gecos/session/*", "tests/cpp/session/*")
GECOS = (
    *("runtime/cpp/gecos/*", "runtime/python/*", "benchmarks/*"),
    *(f"tests/{each}/*" for each in ("cpp/media", "cpp/qos", "cpp/session", "fuzz", "protocol")),
)

INSTEAD: dict[str, str] = {
    "adrift": "pending failover",
    "all up to": "cumulative ack",
    "arm": "prepare to sleep",
    "attend": "add watcher",
    "attended": "watcher",
    "bar": "reject late",
    "baton": "leader lock",
    "bell": "event fd, notify",
    "boot": "incarnation",
    "cast off": "detach",
    "cold": "idle",
    "departed": "closed",
    "disarm": "woke",
    "door": "acceptor",
    "ending": "shutdown, loss",
    "enlist": "register",
    "farewell": "shutdown",
    "give back": "release",
    "given up": "receive window",
    "glance": "poll once",
    "guest": "pending peer",
    "heir": "resumed in",
    "history": "outcome log",
    "hold": "lease acquired",
    "hot": "active",
    "housekeeping": "maintenance",
    "inbox": "receive queue",
    "judge silence": "check liveliness",
    "lab core": "context",
    "last sign": "last heartbeat",
    "leaver": "registered for shutdown",
    "let go": "lease released",
    "lineage": "fork generation",
    "link": "connection",
    "linked session": "client connection",
    "moor": "attach",
    "offer": "capabilities",
    "opening": "handshake initiator",
    "origin": "connect target",
    "outlet": "sealed sender, publisher",
    "overtake": "reorder",
    "overtaken": "reordered",
    "planned": "compiled codec",
    "poke": "notify",
    "renewal": "failover",
    "reserved": "built-in",
    "room": "module",
    "served object": "object host",
    "shapes": "schema",
    "suspect": "dead candidate",
    "tend": "on tick",
    "tended": "tick target",
    "ticket": "queue entry",
    "told": "progress sent",
    "untold": "progress dirty",
    "wakeup": "event fd",
    "watched time": "suspend-aware clock",
}

SCOPES: dict[str, tuple[str, ...]] = {
    "arm": MEDIA,  # elsewhere the arm of a robot or of a union
    "hold": SESSION,
    "link": GECOS,  # elsewhere of a robot, of a file or of a library
    "offer": GECOS,
    "origin": SESSION,  # elsewhere of a coordinate frame
    "ticket": SESSION,
    "told": SESSION,
}
"""Terms that are private in these files only, and plain English or geometry elsewhere."""


@dataclass(frozen=True, slots=True)
class Allowed:
    """Uses of a term that stay."""

    term: str
    files: tuple[str, ...]
    identifiers: tuple[str, ...]
    reason: str

    def covers(self, use: "Use") -> bool:
        return (
            self.term == use.term
            and any(fnmatchcase(use.file, each) for each in self.files)
            and any(fnmatchcase(use.identifier, each) for each in self.identifiers)
        )


@dataclass(frozen=True, slots=True, order=True)
class Use:
    file: str
    identifier: str
    term: str


def allow_list() -> list[Allowed]:
    text = (TREE / "tests/docs/private_terms.toml").read_text(encoding="utf-8")
    table = tomllib.loads(text)
    return [
        Allowed(
            entry["term"],
            tuple(entry.get("files", ["*"])),
            tuple(entry.get("identifiers", ["*"])),
            entry["reason"],
        )
        for entry in table["stays"]
    ]


def sources() -> Iterable[Path]:
    for folder in FOLDERS:
        for file in sorted((TREE / folder).rglob("*")):
            if file.suffix in SUFFIXES and "golden" not in file.parts:
                yield file


def without_text(source: str, suffix: str) -> str:
    """Without comments and without the contents of string literals."""
    if suffix in {".py", ".pyi"}:
        token = r"(\"\"\"|''')[\s\S]*?\1|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|#[^\n]*"
    elif suffix == ".j2":
        token = r"\{#[\s\S]*?#\}|//[^\n]*"
    else:
        token = r"/\*[\s\S]*?\*/|//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])'"
    return re.sub(token, " ", source)


@cache
def words(identifier: str) -> tuple[str, ...]:
    return tuple(each.lower() for each in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", identifier))


def has(term: str, identifier: str) -> bool:
    """As whole words; the last one in the plural too."""
    wanted, own = tuple(term.split()), words(identifier)
    plural = (*wanted[:-1], wanted[-1] + "s")
    starts = range(len(own) - len(wanted) + 1)
    return any(own[at : at + len(wanted)] in (wanted, plural) for at in starts)


@cache
def terms_in(identifier: str) -> tuple[str, ...]:
    return tuple(term for term in INSTEAD if has(term, identifier))


def uses_in(file: str, source: str) -> set[Use]:
    code = without_text(source, Path(file).suffix)
    return {
        Use(file, identifier, term)
        for identifier in set(re.findall(r"[A-Za-z_]\w*", code))
        for term in terms_in(identifier)
        if any(fnmatchcase(file, each) for each in SCOPES.get(term, ("*",)))
    }


@cache
def all_uses() -> frozenset[Use]:
    return frozenset(
        use
        for file in sources()
        for use in uses_in(file.relative_to(TREE).as_posix(), file.read_text(encoding="utf-8"))
    )
