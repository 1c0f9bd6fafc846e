"""`python -m gidl`."""

from gidl.cli.main import run

run()
