"""The page that follows a call names files that exist and functions that are in them."""

import re
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
PAGE = TREE / "docs/life-of-a-call.md"
ROW = re.compile(r"^\| \[[^]]+\]\(([^)]+)\) \| `([\w:]+)` \| ", re.MULTILINE)


def rows() -> list[tuple[str, str]]:
    """File and function of each step."""
    return ROW.findall(PAGE.read_text(encoding="utf-8"))


def test_every_step_names_a_file_and_a_function() -> None:
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    steps = [line for line in lines if line.startswith("| ") and not line.startswith("| file ")]
    assert len(steps) >= 40
    assert [line for line in steps if not ROW.match(line)] == []


def test_every_function_is_in_its_file() -> None:
    """By its whole name in a source, by its last part where a header declares it."""
    missing = []
    for file, function in rows():
        text = (PAGE.parent / file).read_text(encoding="utf-8")
        parts = [function] if file.endswith(".cpp") else function.split("::")
        missing += [(file, part) for part in parts if not re.search(rf"\b{part}\b", text)]
    assert missing == []


def test_every_file_of_the_page_exists() -> None:
    files = re.findall(r"\]\(([^)#]+)\)", PAGE.read_text(encoding="utf-8"))
    assert len(set(files)) >= 30
    assert [file for file in files if not (PAGE.parent / file).exists()] == []


def test_the_way_there_and_back_passes_client_medium_and_server() -> None:
    folders = [file.removeprefix("../") for file, _ in rows()]
    first_of = [
        next(at for at, file in enumerate(folders) if file.startswith(start))
        for start in (
            "generated/cpp/robcl/gripper_client",
            "runtime/cpp/gecos/session/client",
            "runtime/cpp/gecos/media/shm",
            "runtime/cpp/gecos/session/server",
            "generated/cpp/robcl/gripper_server",
            "devices/gripper",
        )
    ]
    assert first_of == sorted(first_of)
