"""The name of this program, which other users see when it holds a robot."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def program_name() -> str:
    """The script's file name, or the module's name under `python -m`, else "python"."""
    spec = getattr(sys.modules.get("__main__"), "__spec__", None)
    if spec is not None and spec.name != "__main__":  # as in a folder or archive
        return str(spec.name).removesuffix(".__main__")
    name = Path(sys.argv[0]).name if sys.argv else ""
    if name in ("", "-", "-c"):
        return "python"
    return name.encode(errors="replace").decode()


def check_environment() -> None:
    """Raises RuntimeError if a variable that names a path or address is not UTF-8, because no
    message could show that value."""
    for variable in ("GECOS_BROKER", "GECOS_RUNTIME_DIR"):
        value = os.environ.get(variable, "")
        try:
            value.encode()
        except UnicodeEncodeError:
            raise RuntimeError(
                f"{variable} is {os.fsencode(value)!r}, which is not UTF-8; name another place"
            ) from None
