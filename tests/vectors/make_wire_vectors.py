"""Writes decoder.json, packet.json, inward_sample.json and frames.json beside itself: what C++ and
Python agree on.

Expected bytes and numbers are computed here with `struct` and plain 3x3 matrices, by neither codec.
Only the verdicts on mutated bytes (`mutations` in decoder.json) are Python's own; the C++ tests
hold them against the C++ decoder. Run it after adding a case, and review the difference.
"""

from __future__ import annotations

import json
import math
import random
import struct
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "python"))

from wire_reads import run_reads  # noqa: E402  (beside the tests that use it)

Case = dict[str, Any]


def text(value: bytes) -> bytes:
    return struct.pack(">i", len(value) + 1) + value + b"\0"


def read(get: str, **more: Any) -> Case:
    return {"get": get, **more}


def accepted() -> list[Case]:
    def case(name: str, data: bytes, reads: list[Case], values: list[Any]) -> Case:
        return {"name": name, "bytes": data.hex(), "reads": reads, "values": values}

    end = read("end")
    numbers = [
        ("int8", "b", -128),
        ("uint8", "B", 255),
        ("int16", "h", -32768),
        ("uint16", "H", 65535),
        ("int32", "i", -(2**31)),
        ("uint32", "I", 2**32 - 1),
        ("int64", "q", -(2**63)),
        ("uint64", "Q", 2**64 - 1),
        ("float", "f", -0.15625),
        ("double", "d", 0.1),
        ("double", "d", -5e-324),
    ]
    cases = [
        case(f"{kind} {value}", struct.pack(">" + code, value), [read(kind), end], [value])
        for kind, code, value in numbers
    ]
    for words in ("", "abc", "Stäubli", "\u07ff\u0800\uffff", "\U00010000\U0010ffff", "x" * 40):
        raw = words.encode()
        cases.append(case(f"string {words!r}", text(raw), [read("string"), end], [words]))
        bound = read("string", max=len(raw))
        cases.append(case(f"string {words!r} at its bound", text(raw), [bound, end], [words]))
    thousand = [0.1 * i for i in range(1000)]
    packed = struct.pack(">i1000d", 1000, *thousand)
    cases += [
        case("booleans", b"\0\1", [read("bool"), read("bool"), end], [False, True]),
        case(
            "a count at its bound",
            struct.pack(">i3b", 3, 1, 2, 3),
            [read("count", min=1, max=3)],
            [3],
        ),
        case(
            "as many empty elements as allowed",
            struct.pack(">i", 65536),
            [read("count", min=0)],
            [65536],
        ),
        case(
            "an array of three int16",
            struct.pack(">3h", 1, -2, 3),
            [read("array", of="int16", count=3), end],
            [[1, -2, 3]],
        ),
        case("an array of nothing", b"", [read("array", of="double", count=0), end], [[]]),
        case(
            "a thousand doubles",
            packed,
            [read("count", min=8), read("array", of="double", count=1000), end],
            [1000, thousand],
        ),
        case(
            "a block whose end is newer than its reader",
            struct.pack(">ihhb", 4, 7, 8, 9),
            [read("block", reads=[read("int16")]), read("int8"), end],
            [[7], 9],
        ),
        case("sixteen levels", b"", [read("enter")] * 16, [None] * 16),
    ]
    return cases


def refused() -> list[Case]:
    def case(name: str, data: bytes, reads: list[Case], problem: str, offset: int) -> Case:
        reads = [{**entry, "field": "f"} for entry in reads]
        verdict = {"problem": problem, "offset": offset, "field": "f"}
        return {"name": name, "bytes": data.hex(), "reads": reads, "refused": verdict}

    def string(name: str, data: bytes, problem: str, most: int | None = None) -> Case:
        entry = read("string") if most is None else read("string", max=most)
        return case(name, data, [entry], problem, 0)

    def count(name: str, number: int, after: int, least: int, problem: str, **more: int) -> Case:
        data = struct.pack(">i", number) + bytes(after)
        return case(name, data, [read("count", min=least, **more)], problem, 0)

    ints = read("int32"), read("int32")
    malformed = {
        "a lone continuation": b"\x80",
        "a cut character": b"\xe2\x82",
        "an overlong slash": b"\xc0\xaf",
        "an overlong in three": b"\xe0\x9f\xbf",
        "an overlong in four": b"\xf0\x8f\xbf\xbf",
        "a surrogate": b"\xed\xa0\x80",
        "above U+10FFFF": b"\xf4\x90\x80\x80",
        "Latin-1 after eight letters": b"Staeubli\xfc",
        "0xff": b"\xff",
    }
    cases = [
        case("nothing where an int8 is expected", b"", [read("int8")], "Truncated", 0),
        case("a second int32 cut short", bytes(7), list(ints), "Truncated", 4),
        case("a boolean of 2", b"\2", [read("bool")], "InvalidBoolean", 0),
        case("a boolean of -1", b"\0\xff", [read("bool"), read("bool")], "InvalidBoolean", 1),
        string("a string without its length", b"\0\0\0", "Truncated"),
        string("a string of length 0", bytes(8), "NegativeCount"),
        string("a string of length -1", b"\xff" * 4 + bytes(4), "NegativeCount"),
        string("a string of length -2**31", b"\x80\0\0\0" + bytes(4), "NegativeCount"),
        string("a string longer than the bytes", struct.pack(">i", 9) + b"abcdefg\0", "Truncated"),
        string("a string of 2**31 - 1", b"\x7f\xff\xff\xff\0", "Truncated"),
        string("a string above its bound", text(b"abcd"), "OverBound", 3),
        string("a long string above its bound", b"\x7f\xff\xff\xff\0", "OverBound", 3),
        string("a string without NUL", struct.pack(">i", 3) + b"abc", "MissingNul"),
        string("a string with NUL inside", struct.pack(">i", 4) + b"a\0b\0", "NulInString"),
        *(
            string(f"a string with {what}", text(b"ok" + raw), "InvalidUtf8")
            for what, raw in malformed.items()
        ),
        count("a count of -1", -1, 8, 1, "NegativeCount"),
        count("a count of -2**31", -(2**31), 8, 1, "NegativeCount"),
        count("a count above its bound", 4, 8, 1, "OverBound", max=3),
        count("a count of more than there is", 9, 8, 1, "Truncated"),
        count("a count of more doubles than there are", 2, 15, 8, "Truncated"),
        count("a count whose product overflows 32 bits", 2**29, 16, 8, "Truncated"),
        count("a count of 2**31 - 1 wide elements", 2**31 - 1, 0, 2**20, "Truncated"),
        count("too many empty elements", 65537, 0, 0, "OverBound"),
        case(
            "an array cut short", bytes(23), [read("array", of="double", count=3)], "Truncated", 0
        ),
        case(
            "a block larger than the bytes",
            struct.pack(">ib", 2, 0),
            [read("block", reads=[])],
            "Truncated",
            0,
        ),
        case(
            "a block of negative size", b"\xff" * 4, [read("block", reads=[])], "NegativeCount", 0
        ),
        case(
            "a read past a block into what follows",
            struct.pack(">iii", 2, 0, 0),
            [read("block", reads=[read("int32", field="f")])],
            "Truncated",
            4,
        ),
        case("seventeen levels", b"", [read("enter")] * 17, "TooDeep", 0),
        case(
            "seventeen levels through a block",
            bytes(4),
            [*[read("enter")] * 16, read("block", reads=[read("enter", field="f")])],
            "TooDeep",
            4,
        ),
    ]
    trailing = case("a byte too many", bytes(5), [read("int32"), read("end")], "TrailingBytes", 4)
    trailing["refused"]["field"] = ""
    return [*cases, trailing]


def mutations() -> tuple[list[Case], list[Case]]:
    """A value of every kind with seeded faults: flipped, cut, inserted and overwritten bytes."""
    inner = struct.pack(">d", 2.5) + text("Gerät".encode()) + b"\1"
    seed = (
        b"\1"
        + text(b"RX90")
        + struct.pack(">i3d", 3, 1.0, 2.0, 3.0)
        + struct.pack(">i", len(inner))
        + inner
        + struct.pack(">Hq", 7, -7)
    )
    reads = [
        read("bool", field="online"),
        read("string", max=8, field="name"),
        read("counted", of="double", max=4, field="joints"),
        read(
            "block",
            field="extra",
            reads=[
                read("enter", field="extra"),
                read("double", field="weight"),
                read("string", field="kind"),
                read("bool", field="held"),
            ],
        ),
        read("uint16", field="port"),
        read("int64", field="stamp"),
        read("end"),
    ]
    source = random.Random(1994)
    cases = []
    for number in range(300):
        data = bytearray(seed)
        for _ in range(source.randint(1, 2)):
            at = source.randrange(len(data))
            match source.randrange(4):
                case 0:
                    data[at] ^= 1 << source.randrange(8)
                case 1:
                    del data[at:]
                    data.append(0)
                case 2:
                    data.insert(at, source.randrange(256))
                case 3:
                    data[at] = source.choice((0, 1, 0x7F, 0x80, 0xFF))
        verdict = run_reads(bytes(data), reads)
        cases.append({"name": f"mutation {number}", "bytes": data.hex(), **verdict})
    return reads, cases


# Frames -----------------------------------------------------------------------------------------

Matrix = list[list[float]]


def about(axis: int, angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    turn = [[0.0] * 3 for _ in range(3)]
    u, v = (axis + 1) % 3, (axis + 2) % 3
    turn[axis][axis] = 1.0
    turn[u][u], turn[u][v], turn[v][u], turn[v][v] = c, -s, s, c
    return turn


def times(a: Matrix, b: Matrix) -> Matrix:
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def homogeneous(turn: Matrix, place: list[float]) -> Matrix:
    return [[*row, p] for row, p in zip(turn, place, strict=True)] + [[0.0, 0.0, 0.0, 1.0]]


def frames() -> dict[str, Any]:
    x, y, z = 0, 1, 2
    orders = {"from_euler_zyz": (z, y, z), "from_euler_zyx": (z, y, x)}
    degrees = [
        (0, 0, 0),
        (30, 40, 50),
        (-30, 40, -50),
        (170, 20, -160),
        (0, 180, 0),
        (90, 90, 90),
        (10, 0, 0),
        (10, 1e-5, 20),
        (45, 180, 0),
        (-120, 89.999, 75),
        (0, 1e-12, 0),
    ]
    made = []
    for how, axes in orders.items():
        for number, angles_deg in enumerate(degrees):
            angles = [math.radians(a) for a in angles_deg]
            place = [0.1 * number, -0.2, 0.3 + number]
            turn = times(
                times(*(about(a, v) for a, v in zip(axes[:2], angles[:2], strict=True))),
                about(axes[2], angles[2]),
            )
            made.append(
                {"make": how, "numbers": [*place, *angles], "matrix": homogeneous(turn, place)}
            )
            if how == "from_euler_zyx":
                made.append(
                    {
                        "make": "from_fixed_xyz",
                        "numbers": [*place, *reversed(angles)],
                        "matrix": homogeneous(turn, place),
                    }
                )
    quaternions = [
        (1.0, 0.0, 0.0, 0.0),
        (0.5, 0.5, 0.5, 0.5),
        (0.5, -0.5, 0.5, -0.5),
        (0.0, 0.0, 1.0, 0.0),
        (-1.0, 0.0, 0.0, 0.0),
        (0.8, 0.6, 0.0, 0.0),
        (0.8000001, 0.6, 0.0, 0.0),
    ]
    encoded = []
    for number, q in enumerate(quaternions):
        numbers = [1.5 * number, -0.1, 1e-300, *q]
        encoded.append({"numbers": numbers, "bytes": struct.pack(">7d", *numbers).hex()})
    return {
        "fingerprint": "249634ce2aa17b5e",
        "made": made,
        "signs": quaternion_signs(),
        "encoded": encoded,
        "refused": list(refused_frames()),
        "read": [
            {
                "matrix": homogeneous(about(y, math.pi), [0.0, 0.0, 0.0]),
                "euler_zyz": [0.0, math.pi, 0.0],
            },
            {
                "matrix": homogeneous(times(about(z, 0.4), about(y, math.pi)), [0.0, 0.0, 0.0]),
                "euler_zyz": [0.4, math.pi, 0.0],
            },
            {
                "matrix": homogeneous(about(z, -2.0), [0.0, 0.0, 0.0]),
                "euler_zyz": [-2.0, 0.0, 0.0],
                "euler_zyx": [-2.0, 0.0, 0.0],
            },
            {
                "matrix": homogeneous(times(about(z, 0.3), about(y, math.pi / 2)), [0.0] * 3),
                "euler_zyx": [0.3, math.pi / 2, 0.0],
                "fixed_xyz": [0.0, math.pi / 2, 0.3],
            },
            {
                "matrix": homogeneous(times(about(z, 0.3), about(y, -math.pi / 2)), [0.0] * 3),
                "euler_zyx": [0.3, -math.pi / 2, 0.0],
            },
        ],
        "text": [
            {
                "make": "from_euler_zyz",
                "numbers": [0.4521, -0.15, 0.4318, 0.0, math.pi / 2, 0.0],
                "text": "(452.1, -150.0, 431.8) mm, ZYZ (0.00, 90.00, 0.00) deg",
            },
        ],
    }


def quaternion_signs() -> list[dict[str, Any]]:
    """Rotation matrices with the quaternion w, x, y, z that both languages read from them: of its
    two signs the one whose first component that is not 0 is positive. They are products of
    rotations by multiples of 45 degrees, among them half turns about and between the axes."""
    signs = []
    for first in range(8):
        for second in range(8):
            for third in range(8):
                halves = [math.radians(45 * turn) / 2 for turn in (first, second, third)]
                q = (1.0, 0.0, 0.0, 0.0)
                for half, axis in zip(halves, (3, 2, 3), strict=True):
                    by = [math.cos(half), 0.0, 0.0, 0.0]
                    by[axis] = math.sin(half)
                    q = quaternion_product(q, tuple(by))
                q = tuple(0.0 if abs(part) < 1e-12 else part for part in q)
                if next(part for part in q if part != 0) < 0:
                    q = tuple(-part + 0.0 for part in q)
                signs.append({"quaternion": list(q), "matrix": homogeneous(rotation(q), [0, 0, 0])})
    return signs


def quaternion_product(left: Any, right: Any) -> Any:
    aw, ax, ay, az = left
    bw, bx, by, bz = right
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
    )


def rotation(q: Any) -> list[list[float]]:
    w, x, y, z = q
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def refused_frames() -> Any:
    good = (0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0)

    def changed(index: int, value: float) -> bytes:
        numbers = [*good]
        numbers[index] = value
        return struct.pack(">7d", *numbers)

    whole = struct.pack(">7d", *good)
    cases = [
        ("position is NaN", changed(0, math.nan), "InvalidValue", 0, "position"),
        ("position is infinite", changed(2, -math.inf), "InvalidValue", 0, "position"),
        ("orientation is zero", changed(3, 0.0), "InvalidValue", 24, "orientation"),
        ("orientation is too long", changed(3, 1.00001), "InvalidValue", 24, "orientation"),
        ("orientation is NaN", changed(6, math.nan), "InvalidValue", 24, "orientation"),
        ("orientation is infinite", changed(5, math.inf), "InvalidValue", 24, "orientation"),
        ("orientation overflows", changed(4, 1e200), "InvalidValue", 24, "orientation"),
        ("cut in the position", whole[:20], "Truncated", 16, "position"),
        ("cut in the orientation", whole[:55], "Truncated", 48, "orientation"),
        ("nothing", b"", "Truncated", 0, "position"),
        ("a byte too many", whole + b"\0", "TrailingBytes", 56, ""),
    ]
    for name, data, problem, offset, field in cases:
        yield {
            "name": name,
            "bytes": data.hex(),
            "refused": {"problem": problem, "offset": offset, "field": field},
        }


def packets() -> dict[str, Any]:
    fingerprint = bytes.fromhex("90a18da222518b52")  # lcm-gen's for docs/protocol-packet.lcm
    cases = []
    for header, body, tag in [
        ((1, 4, 0, 0, 0x81234567, 9, 2**40, 17, 3, 2_000_000_000), b"abc", b""),
        ((1, 9, 0, 0, 0, 0, 0, 0, 0, 0), b"", b""),
        ((2, 100, -1, 0, 2**32 - 1, 2**64 - 1, 2**64 - 1, 2**63, 5, 2**63 - 1), b"", b"\xff" * 16),
    ]:
        data = (
            fingerprint
            + struct.pack(">bbbbIQQQQq", *header)
            + struct.pack(">i", len(body))
            + body
            + struct.pack(">i", len(tag))
            + tag
        )
        names = (
            "version",
            "kind",
            "flags",
            "reserved",
            "code",
            "session",
            "counter",
            "acknowledged",
            "epoch",
            "deadline_ns",
        )
        cases.append(
            {
                **dict(zip(names, header, strict=True)),
                "body": body.hex(),
                "tag": tag.hex(),
                "bytes": data.hex(),
            }
        )
    return {"accepted": cases}


def inward_samples() -> dict[str, Any]:
    """Samples of a client: header and value, as docs/protocol.md has them."""
    cases, fields = [], ("session", "epoch", "command")
    for numbers, value in [
        ((9, 3, 4), struct.pack(">d", 0.25)),
        ((1, 0, 0), b""),
        ((2**64 - 1, 2**63, 2**40), b"\xff"),
    ]:
        data = struct.pack(">3Q", *numbers) + value
        named = dict(zip(fields, numbers, strict=True))
        cases.append({**named, "value": value.hex(), "bytes": data.hex()})
    whole = bytes.fromhex(cases[0]["bytes"])
    cut = [{"bytes": whole[:size].hex(), "field": fields[size // 8]} for size in (0, 7, 8, 15, 23)]
    return {"accepted": cases, "refused": cut}


def listing(content: dict[str, Any]) -> str:
    """JSON with one case on a line, so that a difference shows the case."""
    parts = []
    for key, value in content.items():
        if isinstance(value, list):
            lines = ",\n".join("  " + json.dumps(case, ensure_ascii=False) for case in value)
            parts.append(f" {json.dumps(key)}: [\n{lines}\n ]")
        else:
            parts.append(f" {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main(folder: Path = HERE) -> None:
    reads, mutated = mutations()
    decoder = {
        "accepted": accepted(),
        "refused": refused(),
        "mutation_reads": reads,
        "mutations": mutated,
    }
    for name, content in (
        ("decoder", decoder),
        ("frames", frames()),
        ("packet", packets()),
        ("inward_sample", inward_samples()),
    ):
        (folder / f"{name}.json").write_text(listing(content), encoding="utf-8")


if __name__ == "__main__":
    main()
