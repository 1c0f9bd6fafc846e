"""What a run of `gecos` gives to a test."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from gecos import cli
from jsonschema import Draft202012Validator

Run = Callable[..., tuple[int, str, str]]
"""Runs `gecos` with some words. Returns its exit code, output and error output."""


def valid(text: str, definition: str) -> bool:
    """Whether JSON is as a definition of the published schema says; raises if not."""
    schema = json.loads((Path(cli.__file__).parent / "output.schema.json").read_text())
    validator = Draft202012Validator(schema | {"$ref": f"#/$defs/{definition}"})
    validator.validate(json.loads(text))
    return True
