"""Checks that all C++ is formatted by clang-format. `make format` formats it."""

import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
CLANG_FORMAT = Path(sys.executable).parent / "clang-format"  # tools/requirements has its version


def main() -> int:
    listed = subprocess.run(
        ["git", "ls-files", "*.cpp", "*.hpp", ":!generated"],
        cwd=TREE, check=True, capture_output=True, text=True,
    ).stdout.split()  # fmt: skip
    files = [name for name in listed if (TREE / name).exists()]
    try:
        looked = subprocess.run([CLANG_FORMAT, "--dry-run", "--Werror", *files], cwd=TREE)
    except FileNotFoundError:
        print(f"check_format: there is no {CLANG_FORMAT}; tools/setup.sh format installs it")
        return 1
    if looked.returncode == 0:
        print(f"check_format: {len(files)} files as clang-format lays them out")
    else:
        print("check_format: the files above are laid out differently; run `make format`")
    return looked.returncode


if __name__ == "__main__":
    sys.exit(main())
