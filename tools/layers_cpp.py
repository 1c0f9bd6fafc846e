"""Who may include whom in C++. Every file belongs to a room; a room lists the rooms it may know."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from layers_rule import Violation

# These may include everything except the inner rooms of the session.
PROGRAM = "a program"
PROGRAMS = ("benchmarks", "examples", "tests")
ROOTS = ("runtime/cpp", "runtime/python/src", "devices", "generated/cpp", *PROGRAMS)
SUFFIXES = (".hpp", ".cpp", ".h", ".cc")

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
# What media's users see: the contract, how to wait, and the door that opens what is here.
CONTRACT = re.compile(r"^gecos/media/(?:(?:core|medium|quiet|waiting)\.[hc]pp|open\.hpp)$")
# What an interface is in the words of the session; it stands below all of its rooms.
DESCRIPTION = re.compile(r"^gecos/description\.[hc]pp$")
# The headers that users and generated code include, and their sources.
PUBLIC = re.compile(
    r"^gecos/(?:binding|command|lab|object|reconnecting|reserved|servant|serve|server|stream)"
    r"\.[hc]pp$"
)
HAND_WRITTEN = re.compile(
    r"^(?:gecos/(base|wire|qos|access|crypto|media|session/(?:protocol|process|client|server)|"
    r"broker)|robcl/(frames|arm|motion))/"
)
# A header of devices/ is included from there: "arm/arm_device.hpp". The folders that all devices
# share are rooms of their own.
DEVICE_FOLDERS = {
    folder.name
    for folder in (Path(__file__).resolve().parents[1] / "devices").iterdir()
    if folder.is_dir()
}
SHARED_BY_DEVICES = ("drivers", "support", "arm")
GENERATED = re.compile(r"^(?:[\w]+/)*\w+_(types|json|interface|client|server)\.[hc]pp$")

GENERATED_ROOMS = {
    "types": "generated-types",
    "json": "generated-types",
    "interface": "generated-interfaces",
    "client": "generated-stubs",
    "server": "generated-stubs",
}


@dataclass(frozen=True, slots=True)
class Room:
    """`knows`: the rooms whose headers it may include. `why`: the rule, for people."""

    knows: frozenset[str]
    why: str


def _room(knows: str, why: str) -> Room:
    return Room(frozenset(knows.split()), why)


_BELOW_PROTOCOL = "base wire qos access crypto medium description"
_BELOW_SESSION = _BELOW_PROTOCOL + " generated-types generated-interfaces"
_SESSION = _BELOW_SESSION + " public"
_INWARDS = "the rooms of the session stand on each other: public, protocol, process, client, server"
_BY_CONTRACT = (
    "the session knows media by contract alone (core, medium, quiet, waiting and open.hpp), "
    "and generated types, never clients; "
)

_DEVICE = _BELOW_SESSION + " public umbrella frames generated-stubs"

ROOMS: dict[str, Room] = {
    "base": _room("", "base stands on the standard library alone"),
    "wire": _room("base", "wire knows base alone"),
    "qos": _room("base", "qos knows base alone"),
    "access": _room("base", "access knows base alone: what it needs is passed in"),
    "crypto": _room("base", "crypto knows base alone: bytes in, bytes out"),
    "medium": _room("base qos", "the contract of a medium speaks of bytes and quality alone"),
    "media": _room(
        "base qos crypto medium",
        "a medium moves opaque bytes, sealed where others listen: base, qos, crypto, the contract",
    ),
    "description": _room("base qos access", "a description knows status, quality and base alone"),
    "public": _room(_BELOW_SESSION, _BY_CONTRACT + _INWARDS),
    "session/protocol": _room(
        _BELOW_PROTOCOL + " public",
        "packets know no generated types: what travels in calls is coded by generated code alone",
    ),
    "session/process": _room(_SESSION + " session/protocol", _BY_CONTRACT + _INWARDS),
    "session/client": _room(
        _SESSION + " session/protocol session/process", _BY_CONTRACT + _INWARDS
    ),
    "session/server": _room(
        _SESSION + " session/protocol session/process session/client", _BY_CONTRACT + _INWARDS
    ),
    "umbrella": _room("base public", "gecos.hpp gathers what programs use: base and public"),
    "broker": _room(
        _BELOW_SESSION + " public umbrella generated-stubs",
        "the broker is an object like any other: public headers and generated code, no medium",
    ),
    "frames": _room("base wire", "robcl/frames knows neither session nor generated code"),
    "arm": _room("base wire frames", "robcl/arm knows no session, no generated code, no motion"),
    "motion": _room("base wire frames arm", "robcl/motion knows no session and no generated code"),
    "generated-types": _room(
        "base wire frames", "generated types know the codec and hand-written values"
    ),
    "generated-interfaces": _room(
        "base wire qos access description generated-types",
        "descriptions of interfaces and what calls take and give stand below the session",
    ),
    "generated-stubs": _room(
        _BELOW_SESSION + " frames public",
        "generated clients and servers know public headers and types",
    ),
    "devices/drivers": _room(
        "base frames arm", "a joint driver knows joints and hardware: no session, no generated code"
    ),
    "devices/support": _room(
        _DEVICE, "what every device needs knows no device: no medium, no broker, no arm"
    ),
    "devices/arm": _room(
        _DEVICE + " arm motion devices/drivers devices/support",
        "the servants of all arms know drivers and support, and no exact arm",
    ),
    "devices": _room(
        _DEVICE + " arm motion devices/drivers devices/support devices/arm",
        "a device is a generated skeleton, robcl and one piece of hardware: no medium, no broker",
    ),
    "binding": _room(
        _BELOW_SESSION + " public umbrella broker",
        "the binding sits on public headers and broker, at the byte seam: no generated client",
    ),
}


@dataclass(frozen=True, slots=True)
class Guest:
    """A library, or a room, that only some files may include."""

    header: re.Pattern[str]
    where: re.Pattern[str]
    name: str
    rule: str


INNER_ROOMS = Guest(
    re.compile(r"^gecos/session/"),
    re.compile(r"^(runtime/cpp/gecos/session|tests/cpp/session|tests/fuzz|tests/stress)/"),
    "an inner room of the session",
    "the session and its tests know its rooms; all others include the public headers in gecos/",
)
GUESTS = (
    INNER_ROOMS,
    Guest(
        re.compile(r"^gecos/session/client/"),
        re.compile(r"^(?!runtime/cpp/gecos/session/server/(?!(server|registrar)\.))"),
        "the client side",
        "the server is a client of the broker only: in server.cpp and registrar",
    ),
    Guest(
        re.compile(r"^lcm/"),
        re.compile(r"^runtime/cpp/gecos/media/lcm\.cpp$"),
        "LCM",
        "lcm.h appears in gecos/media/lcm.cpp alone",
    ),
    Guest(
        re.compile(r"^(kdl|kdl_parser|Eigen|eigen3|unsupported/Eigen|urdf\w*)/"),
        re.compile(r"^(runtime/cpp/robcl|devices)/"),
        "KDL, Eigen or urdfdom",
        "KDL, Eigen and urdfdom appear in robcl/ and devices/ alone",
    ),
    Guest(
        re.compile(r"^nanobind/"),
        re.compile(r"^runtime/python/src/"),
        "nanobind",
        "nanobind appears in runtime/python/src alone",
    ),
    Guest(
        re.compile(r"^Python\.h$"),
        re.compile(r"^runtime/python/src/"),
        "the Python C API",
        "C++ outside runtime/python/src never calls Python",
    ),
    Guest(
        re.compile(r"^sodium(\.h|/)"),
        re.compile(r"^runtime/cpp/gecos/crypto/"),
        "libsodium",
        "libsodium appears in gecos/crypto alone",
    ),
    Guest(
        re.compile(r"^nlohmann/"),
        re.compile(r"^runtime/cpp/gecos/wire/json"),
        "the JSON library",
        "nlohmann's JSON appears in gecos/wire/json* alone",
    ),
)

PURE_ROOMS = ("wire", "qos", "access", "crypto")
# A user's keys are files, and the one file that looks after them may do I/O.
KEY_KEEPER = "runtime/cpp/gecos/crypto/key_directory.cpp"
IMPURE_HEADER = re.compile(
    r"^(thread|mutex|shared_mutex|condition_variable|future|fstream|iostream|filesystem|"
    r"sys/.*|unistd\.h|poll\.h|fcntl\.h|pthread\.h|netinet/.*|arpa/.*|time\.h|ctime)$"
)
IMPURE_CALL = re.compile(r"\b(?:\w*[cC]lock::now|clock_gettime|gettimeofday)\s*\(")
PURE_RULE = "wire, qos, access and crypto do no I/O, own no thread and read no clock"


# What travels in calls is stated in .gidl, and its codec and description are generated.
CALLING_ROOMS = ("session/process", "session/client", "session/server", "broker")
CODED = re.compile(
    r"\.(?:put|put_string|put_count|get_string|get_count)\(|\.get\([^)]|"
    r"\b(?:get|put)_(?:block|sequence|optional|array|map)\(|\bdecode_enum\("
)
DESCRIBED = re.compile(r"(?<!const )\bOperationDescription(?: \w+)? ?[;{(=,]")
BY_HAND_RULE = (
    "calls, their results and the descriptions of operations are generated from idl/; packets are "
    "coded in session/protocol"
)


def room_of_file(path: str) -> str | None:
    """Room of a file of the tree."""
    if path.startswith(tuple(root + "/" for root in PROGRAMS)):
        return PROGRAM
    if path.startswith("runtime/python/src/"):
        return "binding"
    if path.startswith("devices/"):
        return room_of_device(path.split("/")[1])
    for root in ("runtime/cpp/", "generated/cpp/"):
        if path.startswith(root):
            return room_of_header(path.removeprefix(root))
    return None


def room_of_header(header: str) -> str | None:
    """Room of a header as it is written in an include; None when it is not one of ours."""
    if CONTRACT.match(header):
        return "medium"
    if DESCRIPTION.match(header):
        return "description"
    if PUBLIC.match(header):
        return "public"
    if header == "gecos/gecos.hpp":
        return "umbrella"
    hand_written = HAND_WRITTEN.match(header)
    if hand_written:
        return hand_written[1] or hand_written[2]
    generated = GENERATED.match(header)
    if generated:
        return GENERATED_ROOMS[generated[1]]
    folder = header.split("/")[0]
    return room_of_device(folder) if folder in DEVICE_FOLDERS else None


def room_of_device(folder: str) -> str:
    return f"devices/{folder}" if folder in SHARED_BY_DEVICES else "devices"


def files(tree: Path) -> Iterator[Path]:
    for root in ROOTS:
        for path in sorted((tree / root).rglob("*")):
            if path.suffix in SUFFIXES and path.is_file():
                yield path


def violations(path: str, text: str) -> list[Violation]:
    room = room_of_file(path)
    if room is None:
        return [
            Violation(
                path,
                1,
                "this file stands in no room",
                "every C++ file of runtime/ and devices/ belongs to a room of docs/architecture.md",
                "move it into a room, or give its room a line in ROOMS of tools/layers_cpp.py",
            )
        ]
    found: list[Violation] = []
    for number, line in enumerate(text.splitlines(), start=1):
        include = INCLUDE.match(line)
        if include:
            found += _include(path, number, room, include[2])
        elif _by_hand(room, line.split("//")[0]):
            found.append(
                Violation(
                    path,
                    number,
                    f"{room} codes fields, or describes an operation, by hand",
                    BY_HAND_RULE,
                    "declare it in idl/gecos and use what gidl generates for its calls",
                )
            )
        elif room in PURE_ROOMS and IMPURE_CALL.search(line.split("//")[0]):
            found.append(
                Violation(
                    path, number, f"{room} reads a clock", PURE_RULE, "take the time as an argument"
                )
            )
    return found


def _by_hand(room: str, code: str) -> bool:
    """Whether a line codes what travels in a call, or describes an operation."""
    if room in CALLING_ROOMS and CODED.search(code):
        return True
    return room in (*CALLING_ROOMS, "session/protocol") and bool(DESCRIBED.search(code))


def _include(path: str, line: int, room: str, header: str) -> list[Violation]:
    for guest in (INNER_ROOMS,) if room == PROGRAM else GUESTS:
        if guest.header.match(header) and not guest.where.match(path):
            return [
                Violation(
                    path,
                    line,
                    f"<{header}>: {guest.name} has no place here",
                    guest.rule,
                    "use what the room that owns it offers, or extend that room",
                )
            ]
    if room in PURE_ROOMS and path != KEY_KEEPER and IMPURE_HEADER.match(header):
        return [
            Violation(
                path,
                line,
                f"<{header}> in {room}",
                PURE_RULE,
                "let the caller do it and pass the result in",
            )
        ]
    target = room_of_header(header)
    if room == PROGRAM:
        return []
    allowed = ROOMS[room].knows
    if target is None or target == room or target in allowed:
        return []
    choice = ", ".join(sorted(allowed)) or "nothing of ours"
    return [
        Violation(
            path,
            line,
            f'{room} includes "{header}" of {target}',
            ROOMS[room].why,
            f"it may include {choice}: pass in what it needs, or move the code to a room that may",
        )
    ]
