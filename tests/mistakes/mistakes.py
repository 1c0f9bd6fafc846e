"""The tables of mistakes: what a user did, what the message must be, and what the message tells.

Each table is a TOML file with entries `[[mistake]]`:

    name     what the user did wrong, in a few words
    python | gecos | gidl | program | cpp | compile | cmake   what makes the mistake; see `KINDS`
    says     the golden message; <…> stands for what differs between two runs
    what, where, do   the parts of `says` that tell what is wrong, where, and what to do;
             empty where the message does not tell it. `do` begins as an instruction does, or asks
             what was meant; the limits of a value or the names of what there is are none.
    files    of `gidl` and `gecos`: the files that the command finds in its folder
"""

from __future__ import annotations

import getpass
import os
import re
import socket
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]
CPP_KINDS = ("cpp", "compile", "cmake")
KINDS = ("python", "gecos", "gidl", "program", *CPP_KINDS)
"""`python`: code for the test's own process, which has a laboratory; `gecos` and `gidl`: the words
of a command; `program`: code for a Python of its own. `cpp`: the body of a function of the program
cpp_mistakes; `compile`: C++ that the compiler refuses or warns of; `cmake`: a part of a
CMakeLists.txt. What compilers and CMake say differs between their versions, so `says` has only the
parts of lines that are ours, in their order."""
PARTS = ("what", "where", "do")
INSTRUCTION = re.compile(
    r"(add|allow|ask|call|catch|check|choose|convert|create|declare|get|give|install|keep|make"
    r"|move|name|rename|run|say|send|serve|set|shorten|start|swap|try|use|write)\b"
    r"|must (be|have|catch|outlive) |is missing|expects|-I adds|did you mean|is the \w+ in ",
    re.IGNORECASE,
)
"""How the part `do` of a message begins."""


@dataclass(frozen=True, slots=True)
class Mistake:
    name: str
    kind: str
    made_by: str
    says: str
    parts: Mapping[str, str]
    table: str
    files: Mapping[str, str] = field(default_factory=dict)

    @property
    def grade(self) -> int:
        """How many of the three parts the message tells: 0 to 3."""
        return sum(bool(part) for part in self.parts.values())

    @property
    def is_cpp(self) -> bool:
        return self.kind in CPP_KINDS


def read_table(file: Path) -> Iterator[Mistake]:
    for entry in tomllib.loads(file.read_text(encoding="utf-8"))["mistake"]:
        (kind,) = entry.keys() & set(KINDS)
        yield Mistake(
            entry["name"],
            kind,
            entry[kind],
            entry["says"].strip("\n"),
            {part: entry[part] for part in PARTS},
            file.stem,
            entry.get("files", {}),
        )


def all_mistakes() -> list[Mistake]:
    return [mistake for file in sorted(HERE.glob("*.toml")) for mistake in read_table(file)]


def of_kind(kind: str) -> list[Mistake]:
    return [mistake for mistake in all_mistakes() if mistake.kind == kind]


def write_files(mistake: Mistake, folder: Path) -> None:
    for name, text in mistake.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def settled(text: str, *folders: Path) -> str:
    """`text` with <…> for what differs between two runs and machines."""
    for place in folders:
        text = text.replace(str(place), "<folder>")
    text = text.replace(sys.executable, "<python>").replace(str(TREE), "<tree>")
    runtime = os.environ.get("GECOS_RUNTIME_DIR")
    text = text.replace(runtime, "<runtime>") if runtime else text
    text = re.sub(rf"\b{os.getpid()}\b", "<pid>", text)
    text = text.replace(f"{getpass.getuser()}@{socket.gethostname()}", "<user>@<host>")
    text = text.replace(socket.gethostname(), "<host>")
    text = re.sub(r"\(pid \d+\)|\bpid \d+", "pid <pid>", text)
    text = re.sub(r"\buid \d+", "uid <uid>", text)
    text = re.sub(r"\(request [0-9a-f-]+\)", "(request <id>)", text)
    text = re.sub(r"\b\d+(\.\d+)? m?s ago|(for|since|in) \d+(\.\d+)? m?s\b", "<time>", text)
    text = re.sub(
        rf"\b{re.escape(getpass.getuser())} on <host> \([^,)]*,",
        "<user> on <host> (<program>,",
        text,
    )
    text = text.replace(f"of {getpass.getuser()} on <host>", "of <user> on <host>")
    text = text.replace(f"the program of {getpass.getuser()} loses", "the program of <user> loses")
    text = as_python_311_says(text)
    return "\n".join(line.rstrip() for line in text.strip("\n").splitlines())


def as_python_311_says(text: str) -> str:
    """`text` with the words of Python 3.11 in place of those of later versions."""
    text = re.sub(r"\.cpython-\d+-[\w-]+\.so\b", ".<python>.so", text)
    text = re.sub(r"(?<=\(choose from ).*?(?=\))", lambda names: names[0].replace("'", ""), text)
    return re.sub(
        r"without an implementation for (abstract methods? )(.*)",
        lambda told: "with " + told[1] + told[2].replace("'", ""),
        text,
    )
