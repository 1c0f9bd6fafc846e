"""The name of this program, which other users see while the program holds a robot."""

from __future__ import annotations

import os
import sys


def program_name() -> str:
    """Returns the script's file name, or the module's name under `python -m`, or else "python"."""
    spec = getattr(sys.modules.get("__main__"), "__spec__", None)
    # The name "__main__" means that a folder or archive was run.
    if spec is not None and spec.name != "__main__":
        return str(spec.name).removesuffix(".__main__")
    name = os.path.basename(sys.argv[0]) if sys.argv else ""  # noqa: PTH119  # pathlib takes long
    if name in ("", "-", "-c"):
        return "python"
    return name.encode(errors="replace").decode()


def check_environment() -> None:
    """Raises RuntimeError if GECOS_BROKER, GECOS_LAB_FILE or GECOS_RUNTIME_DIR is not UTF-8. Error
    messages are UTF-8 and could not show such a value."""
    for variable in ("GECOS_BROKER", "GECOS_LAB_FILE", "GECOS_RUNTIME_DIR"):
        value = os.environ.get(variable, "")
        try:
            value.encode()
        except UnicodeEncodeError:
            raise RuntimeError(
                f"{variable} is {os.fsencode(value)!r}, which is not UTF-8; set it to valid UTF-8"
            ) from None
