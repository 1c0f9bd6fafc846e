"""`gecos why`: what became of a request, by the audit of a server in this process."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path

import gecos
import pytest
from command_output import Run, valid
from robcl.frames import Frame
from shelf import Shelf


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("GECOS_AUDIT_DIR", str(tmp_path / "audit"))
    return tmp_path / "audit"


def write(folder: Path, name: str, *lines: object) -> None:
    folder.mkdir(exist_ok=True)
    text = "".join(line if isinstance(line, str) else f"{json.dumps(line)}\n" for line in lines)
    (folder / name).write_text(text)


def command(request: str, **more: object) -> dict[str, object]:
    who = {"user": "ben", "host": "desk", "program": "lift.py", "pid": 12}
    about = {"event": "command", "object": "RX90", "request": request, "operation": "move"}
    return {"time": "2026-11-27T23:01:02.007Z", **about, "outcome": "DONE", **who, **more}


def test_a_refusal_is_explained_by_the_number_at_its_end(
    folder: Path, lab: gecos.Lab, run: Run
) -> None:
    with gecos.Server(lab) as server:
        server.add("SHELF", Shelf())
        from robcl.device import Device

        shelf = lab.create(Device, "SHELF")
        with pytest.raises(gecos.CommandFailed) as refused:
            shelf.mount("", Frame()).result()
        number = re.search(r"\(request (\S+)\)$", str(refused.value))
        assert number, str(refused.value)
        deadline = time.monotonic() + 20
        while run("why", number[1])[0] != 0:
            assert time.monotonic() < deadline, "no line about the refusal was written"
        code, out, _ = run("why", number[1])
        assert code == 0
        assert "mount ended DENIED: 'mount' of SHELF needs actor status" in out
        _, out, _ = run("why", number[1], "--json")
        assert valid(out, "why")
        assert json.loads(out)[0]["request"] == number[1]


def test_lines_of_all_files_are_read_from_old_to_new(folder: Path, run: Run) -> None:
    write(folder, "audit.2.jsonl", command("a-b-1", event="command_begins"))
    write(folder, "audit.1.jsonl", "half a li", "\n", command("a-b-2"))
    write(folder, "audit.jsonl", command("a-b-1", outcome="STOPPED", why="stopped by ann"))
    code, out, _ = run("why", "A-B-1")
    assert code == 0
    assert out.splitlines() == [
        "2026-11-27T23:01:02.007Z RX90: ben on desk (lift.py, pid 12): begins move",
        "2026-11-27T23:01:02.007Z RX90: ben on desk (lift.py, pid 12): move ended STOPPED: stopped "
        "by ann",
    ]


def test_a_request_that_was_only_counted_is_found(folder: Path, run: Run) -> None:
    write(folder, "audit.jsonl", command("a-b-2", last_request="a-b-10", count=9))
    code, out, _ = run("why", "a-b-c")
    assert code == 0
    assert "move ended DONE (9 requests up to a-b-10)" in out
    assert run("why", "a-b-11")[0] == 1


def test_a_session_whose_number_contains_another_one_is_another_session(
    folder: Path, run: Run
) -> None:
    write(folder, "audit.jsonl", command("fa-b1-2", last_request="fa-b1-10", count=9))
    assert run("why", "a-b1-c")[0] == 1
    assert run("why", "fa-b1-c")[0] == 0


def test_a_request_of_which_nothing_is_known_names_the_folder(folder: Path, run: Run) -> None:
    code, _, err = run("why", "1a2b-3c4d-7")
    assert code == 1
    assert f"the audit in {folder} has no line about 1a2b-3c4d-7" in err
    code, _, err = run("why", "RX90")
    assert code == 2
    assert "RX90 is not the number of a request" in err
