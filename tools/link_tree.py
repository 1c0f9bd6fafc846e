"""Makes the packages and commands of the tree known to the virtual environment that runs this.

An editable install of each package would do the same, but would compile the C++ once more. This
script compiles nothing, because CMake puts the extension module into the tree.
"""

import stat
import sys
import sysconfig
import tomllib
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
PACKAGES = ("codegen", "runtime/python", "generated/python")
PROJECTS = ("pyproject.toml", "codegen/pyproject.toml")

SCRIPT = """\
#!{python}
import sys
from {module} import {function}

sys.exit({function}())
"""


def link_packages(site: Path) -> None:
    """Lets `import gidl`, `import gecos` and `import robcl` find the tree."""
    lines = [str(TREE / package) for package in PACKAGES]
    (site / "robcl-tree.pth").write_text("\n".join(lines) + "\n")


def link_commands(folder: Path) -> None:
    """Writes one script for each command that a pyproject.toml declares."""
    for project in PROJECTS:
        declared = tomllib.loads((TREE / project).read_text())["project"].get("scripts", {})
        for name, target in declared.items():
            module, function = target.split(":")
            script = folder / name
            script.write_text(
                SCRIPT.format(python=sys.executable, module=module, function=function)
            )
            script.chmod(script.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)


if __name__ == "__main__":
    if sys.prefix == sys.base_prefix:
        sys.exit("link_tree: run this with the tree's own interpreter, .venv/bin/python")
    link_packages(Path(sysconfig.get_path("purelib")))
    link_commands(Path(sysconfig.get_path("scripts")))
