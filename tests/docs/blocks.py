"""Code in the documents: found, wrapped up as a program, and judged by a compiler."""

import os
import re
import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]


def blocks(document: str, language: str) -> list[str]:
    """What is fenced as `language`, in its order."""
    text = (TREE / document).read_text(encoding="utf-8")
    found = re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert found, f"{document} has no {language} block"
    return found


def run(*command: object, **environment: str) -> None:
    done = subprocess.run(
        [str(word) for word in command],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def compile_cpp(program: str, generated: Path, folder: Path) -> None:
    """Raises AssertionError with what the compiler says. `generated` has the oven."""
    source = folder / "program.cpp"
    source.write_text(program)
    roots = [TREE / "runtime/cpp", TREE / "generated/cpp", generated / "cpp"]
    run(
        *("c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra"),
        *(["-Werror"] if os.environ.get("GECOS_WERROR") == "ON" else []),
        *(f"-I{root}" for root in roots),
        "-isystem/usr/include/eigen3",
        source,
    )


def check_python(program: str, generated: Path, folder: Path) -> None:
    """Raises AssertionError with what mypy says."""
    source = folder / "program.py"
    source.write_text(program)
    roots = [TREE / "runtime/python", TREE / "generated/python", generated / "python"]
    run(
        *(sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases"),
        *("--config-file", os.devnull, "--cache-dir", folder / "cache"),
        source,
        MYPYPATH=":".join(str(root) for root in roots),
    )
