"""Prints a model as OMG IDL, for tools that do not read .gidl: `gidl dump --omg=corba|dds`."""

from __future__ import annotations

from collections.abc import Mapping

from gidl.diagnostics.findings import Findings
from gidl.model import Model
from gidl.omg.corba import CorbaWriter
from gidl.omg.dds import DdsWriter
from gidl.omg.writer import OmgWriter

DIALECTS: Mapping[str, type[OmgWriter]] = {"corba": CorbaWriter, "dds": DdsWriter}


def omg_text(model: Model, dialect: str, whole: bool, findings: Findings) -> str:
    """Prints the files that the user asked for as OMG IDL in `dialect`; with `whole`, prints all
    files. Each construct that the dialect cannot express becomes a finding."""
    return DIALECTS[dialect](model, findings).text(whole)
