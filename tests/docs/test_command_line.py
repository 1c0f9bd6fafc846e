"""The lines of JSON on the page of the command line have the members of the published schema."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from test_documents import TREE, text_of

EXAMPLE = re.compile(r"^\$ gecos ([a-z]+).* --json\n(.+)$", re.MULTILINE)
SCHEMA = json.loads(text_of(TREE / "runtime/python/gecos/cli/output.schema.json"))["$defs"]


def unknown(shown: Any, schema: dict[str, Any] | bool) -> list[str]:
    """The members that the schema does not have."""
    if isinstance(schema, bool):
        return []  # any value
    if "$ref" in schema:
        return unknown(shown, SCHEMA[schema["$ref"].rpartition("/")[2]])
    if isinstance(shown, list):
        return [each for item in shown for each in unknown(item, schema["items"])]
    if not isinstance(shown, dict) or "properties" not in schema:
        return []
    known = schema["properties"]
    below = [each for name in known.keys() & shown for each in unknown(shown[name], known[name])]
    return sorted(shown.keys() - known) + below


@pytest.mark.parametrize(
    ("command", "line"), EXAMPLE.findall(text_of(TREE / "docs/command-line.md"))
)
def test_an_example_has_the_members_that_the_command_prints(command: str, line: str) -> None:
    shown = json.loads(line.replace(", …", ""))
    definition = "failure" if "error" in shown else command
    assert unknown(shown, SCHEMA[definition]) == []


def test_each_command_that_scripts_read_has_an_example() -> None:
    shown = {command for command, _ in EXAMPLE.findall(text_of(TREE / "docs/command-line.md"))}
    assert {"ls", "get", "set", "call", "watch", "hz", "wait", "holders", "stop"} <= shown
