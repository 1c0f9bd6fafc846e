"""Checks that each C++ file of ours includes the headers whose free functions it calls, directly or
through other headers.

A build that unites sources does not notice a missing header, because another source of the same
unit includes it. `make release` unites no sources, and fails. This check reads only the text: it
takes seconds, where a compiler takes minutes. It looks at the free functions that exactly one
header declares. It ignores a call if the file or its headers also declare something else with this
name, for example a member.
"""

import re
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
ROOTS = ("runtime", "devices")
INCLUDE_ROOTS = ("runtime/cpp", ".", "generated/cpp")
NO_CODE = re.compile(r'//[^\n]*|R"\((?:.|\n)*?\)"|"(?:[^"\\\n]|\\.)*"')
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
# A declaration at namespace scope begins a line; members and local names are indented.
FUNCTION = re.compile(r"^[\w\[][^=;{}()\n]*[\s&*>]([a-z]\w+)\(", re.MULTILINE)
NESTED = re.compile(
    r"^ +(?! |return|throw|else|co_)[^=;(){}\n]*[\w&*>\]] [&*]*([a-z]\w+)(?: = |[({;])",
    re.MULTILINE,
)
KEYWORDS = {"alignas", "decltype", "requires"}
CALL = re.compile(r"(?<![\w.>:~])(?:\w+::)*([a-z]\w+)\(")


@cache
def code(file: Path) -> str:
    return NO_CODE.sub('""', file.read_text(encoding="utf-8"))


@cache
def free_functions(file: Path) -> set[str]:
    return set(FUNCTION.findall(code(file))) - KEYWORDS


@cache
def nested_names(file: Path) -> set[str]:
    """Returns the members and local variables, which may have the name of a free function."""
    return set(NESTED.findall(code(file)))


@cache
def included(file: Path, tree: Path) -> frozenset[Path]:
    """Returns the headers of the tree that `file` includes, directly or through others."""
    found: set[Path] = set()
    waiting = [file]
    while waiting:
        at = waiting.pop()
        for name in INCLUDE.findall(at.read_text(encoding="utf-8")):
            for folder in (at.parent, *(tree / root for root in INCLUDE_ROOTS)):
                header = (folder / name).resolve()
                if header.is_file() and header not in found:
                    found.add(header)
                    waiting.append(header)
    return frozenset(found)


def violations(tree: Path) -> tuple[int, list[str]]:
    files = [f.resolve() for root in ROOTS for f in sorted((tree / root).rglob("*.[ch]pp"))]
    homes: dict[str, list[Path]] = defaultdict(list)
    for file in files:
        for name in free_functions(file):
            homes[name].append(file)
    headers = {
        name: places[0]
        for name, places in homes.items()
        if {place.suffix for place in places if place != places[0]} <= {".cpp"}
        and places[0].suffix == ".hpp"
    }
    found: list[str] = []
    for file in files:
        seen = {file, *included(file, tree)}
        known = set().union(*map(free_functions, seen), *map(nested_names, seen))
        for name in sorted({*CALL.findall(code(file))} - known):
            if header := headers.get(name):
                user, home = (each.relative_to(tree.resolve()) for each in (file, header))
                found.append(f"{user}: calls {name}, but does not include {home}")
    return len(files), found


def main() -> int:
    tree = Path(sys.argv[1]) if len(sys.argv) > 1 else TREE
    count, found = violations(tree)
    print("\n".join((*found, f"check_includes: {count} files, {len(found)} missing headers")))
    return 1 if found or not count else 0


if __name__ == "__main__":
    sys.exit(main())
