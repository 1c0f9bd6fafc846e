"""`python -m gidl`."""

from gidl.cli import run

run()
