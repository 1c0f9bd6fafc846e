"""Prints Python text for nodes of the wire layout: type hints, default values and layout steps."""

from __future__ import annotations

from gidl.targets.python.lower.steps import Lowering
from gidl.targets.python.lower.types import CODES

__all__ = ["CODES", "Lowering"]
