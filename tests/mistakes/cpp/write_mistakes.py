"""write_mistakes.py <table> <output>: the C++ functions that make the mistakes of a table."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

FUNCTION = """\
// {name}
void mistake_{number}([[maybe_unused]] Bench& here) {{
  [[maybe_unused]] gecos::Lab& lab = here.lab;
  [[maybe_unused]] gecos::Server& server = here.server;
  [[maybe_unused]] const lab::Table& table = here.table;
  [[maybe_unused]] Turntable& servant = here.servant;
{code}
}}
"""


def source(table: Path) -> str:
    entries = tomllib.loads(table.read_text(encoding="utf-8"))["mistake"]
    made = [entry for entry in entries if "cpp" in entry]
    functions = [
        FUNCTION.format(name=entry["name"], number=i, code=entry["cpp"].strip("\n"))
        for i, entry in enumerate(made)
    ]
    rows = [f'    {{"{entry["name"]}", mistake_{i}}},' for i, entry in enumerate(made)]
    return "\n".join(
        (
            '#include "bench.hpp"\n\nnamespace {\n',
            *functions,
            "}  // namespace\n\nconst std::map<std::string, MakeMistake> mistakes{",
            *rows,
            "};\n",
        )
    )


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(source(Path(sys.argv[1])), encoding="utf-8")
