"""The model as plain OMG IDL, for tools that do not know ours: `gidl dump --omg=corba|dds`."""

from __future__ import annotations

from collections.abc import Mapping

from gidl.diagnostics import Findings
from gidl.model import Model
from gidl.omg.corba import CorbaWriter
from gidl.omg.dds import DdsWriter
from gidl.omg.writer import OmgWriter

DIALECTS: Mapping[str, type[OmgWriter]] = {"corba": CorbaWriter, "dds": DdsWriter}


def omg_text(model: Model, dialect: str, whole: bool, findings: Findings) -> str:
    """The files asked for, or all (`whole`), in that dialect. What it cannot express is a finding
    with its place."""
    return DIALECTS[dialect](model, findings).text(whole)
