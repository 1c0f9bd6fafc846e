"""Following the README's "A device from nothing" to the letter gives a device that runs."""

import os
import re
import signal
import subprocess
import tempfile
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]


def commands() -> list[str]:
    """The two blocks of commands of the section: in the tree, and wherever one likes."""
    text = (TREE / "README.md").read_text(encoding="utf-8")
    section = text.split("## A device from nothing\n")[1].split("\n## ")[0]
    return re.findall(r"^```sh\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)


@pytest.mark.timeout(300)
def test_a_device_from_nothing(tmp_path: Path) -> None:
    in_the_tree, wherever = commands()
    build = TREE / os.environ.get("GECOS_BUILD", "build")
    script = f"{in_the_tree}\ncd {tmp_path}\n{wherever}".replace("$ROBCL/build", str(build))
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
            os.killpg(shell.pid, signal.SIGTERM)  # broker and server, which stand behind
            assert os.read(alive, 1) == b""  # comes when the last of them has ended
            os.close(alive)
    text = told.read_text()
    assert status == 0, text
    assert "it reads 20" in text
    assert "and now 21.5" in text
