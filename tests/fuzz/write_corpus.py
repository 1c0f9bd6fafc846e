"""Writes the shared vectors as the inputs that decoder_fuzzer.cpp starts from, into a folder."""

from __future__ import annotations

import json
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
VECTORS = TREE / "tests" / "vectors"


def inputs() -> list[bytes]:
    """Each begins with the byte that chooses: 0 a packet, then the types by name."""
    packets = json.loads((VECTORS / "packet.json").read_text(encoding="utf-8"))["accepted"]
    types = json.loads((VECTORS / "types.json").read_text(encoding="utf-8"))
    numbers = {name: i for i, name in enumerate(sorted({case["type"] for case in types}), start=1)}
    return [
        *(b"\0" + bytes.fromhex(packet["bytes"]) for packet in packets),
        *(bytes([numbers[case["type"]]]) + bytes.fromhex(case["bytes"]) for case in types),
    ]


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for i, data in enumerate(inputs()):
        (folder / f"vector-{i:03}").write_bytes(data)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
