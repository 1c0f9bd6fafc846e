"""Checks the layer rules: direct includes and imports of all built and generated files.

The rules are tables, in layers_cpp.py and layers_python.py; docs/architecture.md gives the reasons.
"""

import sys
from collections.abc import Iterable
from pathlib import Path

import layers_cpp
import layers_python
from layers_rule import Violation

TREE = Path(__file__).resolve().parent.parent


def check(tree: Path) -> tuple[int, list[Violation]]:
    """Returns the number of files that were checked below `tree`, and their violations."""
    files = 0
    violations: list[Violation] = []
    for language in (layers_cpp, layers_python):
        for path in language.files(tree):
            files += 1
            name = path.relative_to(tree).as_posix()
            violations += language.violations(name, path.read_text(encoding="utf-8"))
    return files, violations


def report(files: int, violations: Iterable[Violation]) -> str:
    found = sorted(violations)
    lines = [str(violation) for violation in found]
    lines.append(f"check_layers: {files} files, {len(found)} violations")
    return "\n".join(lines)


def main() -> int:
    tree = Path(sys.argv[1]) if len(sys.argv) > 1 else TREE
    files, violations = check(tree)
    print(report(files, violations))
    if files == 0:
        print(f"no sources below {tree}: nothing was checked", file=sys.stderr)
    return 1 if violations or files == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
