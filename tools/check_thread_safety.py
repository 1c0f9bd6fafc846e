"""Compiles the C++ that uses mutexes with clang's thread-safety analysis.

It is an error to use a member without the mutex that guards it, or to call a function without a
mutex that it requires.

The analysis does not follow calls. Therefore only the sources that see the members are compiled:
those that include gecos/base/mutex.hpp, or a header that includes it. The build's
compile_commands.json says how they are compiled. Headers take most of the time. Therefore the
headers that the sources of one library include are precompiled, and several sources are compiled
together.

The analysis does not know the mutexes of the standard library, so their use is an error, too.
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
ROOTS = ("runtime", "devices")
MUTEX = "gecos/base/mutex.hpp"
MUTEX_FILE = f"runtime/cpp/{MUTEX}"
FLAGS = ("-Wthread-safety", "-Werror")
TOGETHER = 8
"""Sources that are compiled together, as in a unity build."""
PLAIN_MUTEX = re.compile(r"\bstd::(?:recursive_|shared_)?(?:timed_)?mutex\b")


def includes(file: Path) -> set[str]:
    return set(re.findall(r'^#include "([^"]+)"', file.read_text(encoding="utf-8"), re.MULTILINE))


def plain_mutexes(tree: Path) -> list[str]:
    """Returns an error for each line of C++ with a mutex that the analysis does not know."""
    return [
        f"{path}:{number}: error: {found[0]}: the thread-safety analysis does not see it\n"
        f"    = help: use gecos::Mutex of {MUTEX}, with GECOS_GUARDED_BY on each member that it "
        "guards"
        for root in ROOTS
        for file in sorted((tree / root).rglob("*.[ch]pp"))
        if (path := file.relative_to(tree).as_posix()) != MUTEX_FILE
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1)
        if (found := PLAIN_MUTEX.search(line.split("//")[0]))
    ]


def headers_with_mutexes() -> set[str]:
    """Returns the headers with mutexes, by the paths by which other files may include them."""
    found = {MUTEX}
    for root in ROOTS:
        for header in (TREE / root).rglob("*.hpp"):
            if MUTEX in includes(header):
                parts = header.relative_to(TREE).parts
                found.update("/".join(parts[at:]) for at in range(len(parts)))
    return found


def kept(arguments: list[str]) -> tuple[str, ...]:
    """Returns those of the arguments that every compiler accepts."""
    flags: list[str] = []
    for at, argument in enumerate(arguments):
        if argument.startswith(("-I", "-D", "-std=")):
            flags.append(argument)
        elif argument == "-isystem":
            flags += [argument, arguments[at + 1]]
    return tuple(flags)


def compiled(file: Path) -> list[Path]:
    """The sources that one compiler command covers: several, where a build unites them."""
    if file.parent.name != "Unity":
        return [file]
    included = re.findall(r'^#include "([^"]+)"', file.read_text(encoding="utf-8"), re.MULTILINE)
    return [Path(source) for source in included]


def sources(build: Path) -> dict[tuple[str, ...], list[list[Path]]]:
    """Returns the sources to check: for each set of compiler flags, groups of at most `TOGETHER`
    sources of one target."""
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    mutexes = headers_with_mutexes()
    wanted = {
        file for root in ROOTS for file in (TREE / root).rglob("*.cpp") if includes(file) & mutexes
    }
    found: dict[tuple[tuple[str, ...], str], list[Path]] = defaultdict(list)
    for command in commands:
        target = command["command"].partition(" -o ")[2].partition(".dir/")[0]
        for file in compiled(Path(command["file"])):
            if file in wanted:
                wanted.remove(file)
                found[kept(shlex.split(command["command"])), target].append(file)
    if wanted:
        names = ", ".join(str(file.relative_to(TREE)) for file in sorted(wanted))
        raise SystemExit(f"check_thread_safety: {build} does not compile {names}; run make build")
    groups: dict[tuple[str, ...], list[list[Path]]] = defaultdict(list)
    for (flags, _), files in found.items():
        groups[flags] += [files[at : at + TOGETHER] for at in range(0, len(files), TOGETHER)]
    return groups


def clang(*arguments: str) -> str:
    """Returns the messages of clang; an empty text when it finds nothing."""
    command = ("tools/clang.sh", *FLAGS, *arguments)
    ran = subprocess.run(command, cwd=TREE, capture_output=True, text=True, check=False)
    return "" if ran.returncode == 0 else ran.stderr.strip() or f"clang ended with {ran.returncode}"


def check_alike(flags: tuple[str, ...], groups: list[list[Path]], folder: Path) -> list[str]:
    """Returns the problems that clang finds in groups of files which are compiled with the same
    flags, one text for each file with a problem."""
    every = folder / "every.hpp"
    files = [file for group in groups for file in group]
    lines = [line for file in files for line in file.read_text(encoding="utf-8").splitlines()]
    # A header that is included without a folder is found only from its source, so it is left out.
    wanted = sorted({line for line in lines if re.match(r'#include (<|"[^"]*/)', line)})
    every.write_text("#pragma once\n" + "\n".join(wanted) + "\n", encoding="utf-8")
    compiled = f"{every}.pch"
    if problem := clang(*flags, "-x", "c++-header", "-o", compiled, str(every)):
        return [problem]

    def check(some: list[Path], name: str) -> str:
        source = folder / f"{name}.cpp"
        lines = [f'#include "{file}"\n' for file in some]
        source.write_text("".join(lines), encoding="utf-8")
        return clang(*flags, "-fsyntax-only", "-include-pch", compiled, str(source))

    def check_group(at: int) -> list[str]:
        """Checks a group of files at once and, if that fails, one file after the other: the build
        may not compile these files together, and two of them may define the same local name."""
        if not check(groups[at], f"group{at}"):
            return []
        return [check([file], f"group{at}-{nth}") for nth, file in enumerate(groups[at])]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return [
            text for texts in pool.map(check_group, range(len(groups))) for text in texts if text
        ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--build", default=os.environ.get("GECOS_BUILD", "build"))
    asked = parser.parse_args()
    which = subprocess.run(
        ("tools/clang.sh",), cwd=TREE, capture_output=True, text=True, check=False
    )
    if which.returncode != 0:
        print(f"check_thread_safety: {which.stderr.strip()}")
        return 1
    build = TREE / asked.build
    if not (build / "compile_commands.json").is_file():
        print(f"check_thread_safety: {build} has no compile_commands.json; run make build first")
        return 1
    checked = sources(build)
    if not checked:
        print(f"check_thread_safety: no source of {build} uses {MUTEX}")
        return 1
    plain = plain_mutexes(TREE)
    found: list[str] = []
    for flags, groups in checked.items():
        with tempfile.TemporaryDirectory() as folder:
            found += check_alike(flags, groups, Path(folder))
    for text in (*plain, *found):
        print(text)
    count = sum(len(group) for groups in checked.values() for group in groups)
    print(
        f"check_thread_safety: {count} sources, {len(found)} of them with problems, "
        f"{len(plain)} mutexes of the standard library"
    )
    return 1 if plain or found else 0


if __name__ == "__main__":
    sys.exit(main())
