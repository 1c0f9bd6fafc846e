"""The verb `gecos schema`."""

from __future__ import annotations

import click


@click.command()
def schema() -> None:
    """Prints the JSON Schema of the output of `--json`, with a definition for each verb."""
    from pathlib import Path

    print((Path(__file__).parent / "output.schema.json").read_text(encoding="utf-8"), end="")
