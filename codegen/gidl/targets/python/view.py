from __future__ import annotations

from collections.abc import Iterator

from gidl.model import Model
from gidl.targets.naming import OutputFile
from gidl.wire_layout import Layout


def files(model: Model, layout: Layout) -> Iterator[OutputFile]:
    yield from ()
