"""Following the README's "A device from nothing" to the letter gives a device that runs."""

import contextlib
import os
import re
import signal
import subprocess
import tempfile
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]


# What the README says to write into the interface.
CHANGE = """
sed -i -e 's/readonly attribute double/@unit("K") &/' \\
  -e 's/in double/@unit("K") @range(min=0.0, max=400.0) &/' idl/lab/thermometer.gidl
"""


def commands() -> list[str]:
    """The blocks of commands of the section: in the tree, wherever one likes, after a change."""
    text = (TREE / "README.md").read_text(encoding="utf-8")
    section = text.split("## A device from nothing\n")[1].split("\n## ")[0]
    return re.findall(r"^```sh\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)


@pytest.mark.timeout(300)
def test_a_device_from_nothing(tmp_path: Path) -> None:
    in_the_tree, wherever, again = commands()
    build = TREE / os.environ.get("GECOS_BUILD", "build")
    blocks = f"{in_the_tree}\ncd {tmp_path}\n{wherever}\n{CHANGE}\n{again}"
    script = blocks.replace("$ROBCL/build", str(build))
    told = tmp_path / "told"
    # Not below tmp_path: the name of a Unix socket has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="gecos-") as meeting, told.open("w") as out:
        alive, held = os.pipe()  # held open by everything that is started
        shell = subprocess.Popen(
            ["bash", "-eu", "-c", script],
            cwd=TREE,
            env={**os.environ, "GECOS_RUNTIME_DIR": meeting},
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            pass_fds=(held,),
        )
        os.close(held)
        try:
            status = shell.wait(timeout=280)
        finally:
            with contextlib.suppress(ProcessLookupError):  # the last command ends all of them
                os.killpg(shell.pid, signal.SIGTERM)
            assert os.read(alive, 1) == b""  # comes when the last of them has ended
            os.close(alive)
    text = told.read_text()
    assert status == 0, text
    assert text.count("it reads 20\n") == 2
    assert text.count("and now 21.5\n") == 2
    assert "gecos warning lease" not in text
