"""Interfaces of other projects, judged by gidl and by the compilers they were written for.

    python tests/fuzz/public_idl.py FOLDER [-v]

takes every .idl file below FOLDER, one project a subfolder, and asks omniidl, idlc and gidl (with
`--wide=utf8`), each with the same include folders. It prints how many files another compiler takes,
how many of these gidl takes, and for the others the parts of IDL that gidl refuses by name. A file
that is refused otherwise is listed: each of these is a mistake of gidl, or a row for
docs/gidl-differences.md. Run by hand: the files belong to others and are not part of the tree.

    python tests/fuzz/public_idl.py FOLDER --accepted sets.json
    python tests/generated/gate --random 0 --sets sets.json

generates, compiles, imports and compares what gidl takes.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gidl.compile import Compiled, compile_files
from gidl.diagnostics.findings import Severity, as_text

REFUSED = {
    "G0201": "any and TypeCode",
    "G0202": "valuetype",
    "G0203": "fixed",
    "G0204": "long double",
    "G0205": "native",
    "G0207": "abstract interface",
    "G0208": "local interface",
    "G0209": "context",
    "G0210": "components",
    "G0214": "@mutable",
    "G0215": "template modules",
    "G0216": "headers of C",
}
# docs/gidl-differences.md settles these: each with a paragraph of the standard, or a bound of ours.
SETTLED = {
    "G0104": "a keyword as a name, or in another case",
    "G0105": "a member called as its type",
    "G0113": "an interface that is never declared",
    "G0301": "a constant that does not fit",
    "G0306": "an array of nothing, or of too much",
    "G0320": "a base that may grow",
}
SYSTEM = (
    Path("/usr/share/idl/omniORB"),
    Path("/usr/share/idl/omniORB/COS"),
    Path("/usr/share/idl"),
)
INCLUDE = re.compile(rb'^[ \t]*#[ \t]*include[ \t]*["<]([^">\n]+)[">]', re.M)


@dataclass(frozen=True, slots=True)
class Judged:
    file: Path
    omniidl: bool
    idlc: bool
    search: list[str]
    defines: list[str]
    gidl: Compiled

    @property
    def codes(self) -> tuple[str, ...]:
        return tuple(sorted({f.code for f in self.gidl.findings if f.severity is Severity.ERROR}))


class Projects:
    """The files of all projects, and where their includes are found: one may include another's."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._places: dict[str, list[Path]] = defaultdict(list)
        for place in folder.rglob("*"):
            if place.is_file():
                self._places[place.name].append(place)

    def files(self) -> list[Path]:
        return sorted(p for found in self._places.values() for p in found if p.suffix == ".idl")

    def folders(self, file: Path) -> list[Path]:
        """Folders of -I that lead to whatever the file includes, itself or through others."""
        found: dict[Path, None] = {}
        seen = {file}
        work = [file]
        while work:
            now = work.pop()
            for written in INCLUDE.findall(now.read_bytes()):
                name = written.decode("utf-8", "replace")
                beside = now.parent / name
                if beside.is_file():
                    place, folder = beside, now.parent
                else:
                    known = [f / name for f in found if (f / name).is_file()]
                    place = known[0] if known else self._nearest(name, now)
                    if place is None:
                        continue
                    folder = Path(str(place)[: -len(name)].rstrip("/"))
                found[folder] = None
                if place not in seen:
                    seen.add(place)
                    work.append(place)
        return list(found)

    def _nearest(self, name: str, asker: Path) -> Path | None:
        """The file of that name that shares most folders with the one that includes it. Only IDL
        of another project is taken."""
        ending = "/" + name
        own = len(self._folder.parts) + 1
        places = [
            place
            for place in self._places[Path(name).name]
            if str(place).endswith(ending)
            and (place.suffix == ".idl" or _shared(place, asker) >= own)
        ]
        places += [s / name for s in SYSTEM if not places and (s / name).is_file()]
        return max(places, key=lambda p: _shared(p, asker), default=None)


def _shared(one: Path, other: Path) -> int:
    pairs = zip(one.parts, other.parts, strict=False)
    return next((n for n, (a, b) in enumerate(pairs) if a != b), 0)


def judge(projects: Projects, file: Path, scratch: Path) -> Judged:
    folders = [str(f) for f in projects.folders(file)]
    options = [f"-I{folder}" for folder in folders]
    omniidl = _runs(["omniidl", *options, str(file)], scratch)
    idlc = _runs(["idlc", *options, "-o", str(scratch), str(file)], scratch)
    defines = ["__OMNIIDL__"] * omniidl + ["__IDLC__"] * idlc
    found = compile_files([str(file)], folders, wide=True, defines=defines)
    return Judged(file, omniidl, idlc, folders, defines, found)


def _runs(command: list[str], scratch: Path) -> bool:
    """Whether the command ends, and well: some input never lets idlc end."""
    try:
        run = subprocess.run(command, cwd=scratch, capture_output=True, timeout=15, check=False)
    except subprocess.TimeoutExpired:
        return False
    return run.returncode == 0


def judged(folder: Path) -> Iterator[tuple[str, Judged]]:
    with tempfile.TemporaryDirectory() as scratch:
        projects = Projects(folder)
        for file in projects.files():
            yield file.relative_to(folder).parts[0], judge(projects, file, Path(scratch))


def main() -> int:
    parser = argparse.ArgumentParser(description="gidl beside omniidl and idlc")
    parser.add_argument("folder", type=Path)
    parser.add_argument("-v", dest="shows", action="store_true", help="print what gidl says")
    parser.add_argument(
        "--accepted", type=Path, help="write the files that gidl takes, for the gate"
    )
    chosen = parser.parse_args()
    accepted: list[dict[str, object]] = []
    per_project: dict[str, Counter[str]] = defaultdict(Counter)
    refused: Counter[str] = Counter()
    others: dict[tuple[str, ...], list[Judged]] = defaultdict(list)
    for project, one in judged(chosen.folder.resolve()):
        count = per_project[project]
        count["files"] += 1
        count["omniidl"] += one.omniidl
        count["idlc"] += one.idlc
        if not (one.omniidl or one.idlc):
            continue
        count["either"] += 1
        if not one.gidl.has_errors:
            count["gidl"] += 1
            accepted.append(_set(f"{project}_{len(accepted)}", one))
        elif set(one.codes) <= REFUSED.keys():
            refused[" and ".join(REFUSED[code] for code in one.codes)] += 1
        else:
            others[tuple(code for code in one.codes if code not in REFUSED)].append(one)
    if chosen.accepted:
        chosen.accepted.write_text(json.dumps(accepted, indent=1), encoding="utf-8")
    columns = ("files", "omniidl", "idlc", "either", "gidl")
    print(f"{'':32}" + "".join(f"{c:>9}" for c in columns))
    for project, count in per_project.items():
        print(f"{project:32}" + "".join(f"{count[c]:9}" for c in columns))
    total = sum(per_project.values(), Counter[str]())
    print(f"{'together':32}" + "".join(f"{total[c]:9}" for c in columns))
    print(f"\nrefused by name: {refused.total()}")
    for what, number in refused.most_common():
        print(f"{number:5}  {what}")
    settled = {codes: found for codes, found in others.items() if set(codes) <= SETTLED.keys()}
    print(f"\nrefused as docs/gidl-differences.md says: {sum(map(len, settled.values()))}")
    for codes, found in settled.items():
        print(f"{len(found):5}  {' and '.join(SETTLED[code] for code in codes)}")
        _list(found, codes, chosen.shows)
    unexplained = {codes: found for codes, found in others.items() if codes not in settled}
    print(f"\nunexplained: {sum(map(len, unexplained.values()))}")
    for codes, found in unexplained.items():
        print(f"{len(found):5}  {', '.join(codes)}")
        _list(found, codes, chosen.shows)
    return 1 if unexplained else 0


def _set(name: str, one: Judged) -> dict[str, object]:
    """A set of the gate: tests/generated/gate/gate_run.py, `listed`."""
    return {
        "name": re.sub(r"\W", "_", name),
        "file": str(one.file),
        "search": one.search or [str(one.file.parent)],
        "wide": True,
        "defines": one.defines,
    }


def _list(found: list[Judged], codes: tuple[str, ...], shows: bool) -> None:
    for one in found:
        print(f"         {one.file}")
        if shows:
            print(as_text([f for f in one.gidl.findings if f.code in codes], one.gidl.sources))


if __name__ == "__main__":
    sys.exit(main())
