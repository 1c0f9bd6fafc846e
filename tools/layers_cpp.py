"""Allowed includes of C++. Every file belongs to a module, which lists the modules it may know."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from layers_rule import Violation

# Programs may include everything except the inner modules of the session.
PROGRAM = "a program"
PROGRAMS = ("benchmarks", "examples", "tests")
ROOTS = ("runtime/cpp", "runtime/python/extensions", "devices", "generated/cpp", *PROGRAMS)
SUFFIXES = (".hpp", ".cpp", ".h", ".cc")

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
# The headers for users of media: the contract, how to wait, and the header that opens a medium.
CONTRACT = re.compile(r"^gecos/media/(?:(?:core|medium|quiet|waiting)\.[hc]pp|kinds\.hpp)$")
# The description of an interface for the session. Each module of the session may include it.
DESCRIPTION = re.compile(r"^gecos/description\.[hc]pp$")
# The headers that users and generated code include, and their sources.
PUBLIC = re.compile(
    r"^gecos/(?:binding|command|explanation|lab|line|listener|loan|object|object_watch|reconnecting|builtin_operations|servant|serve|"
    r"server|stream|inward|writer)"
    r"\.[hc]pp$"
)
HAND_WRITTEN = re.compile(
    r"^(?:gecos/(base|wire|qos|access|audit|crypto|"
    r"media(?:/(?:buffers|layers|sealed|inproc|shm|lcm|testing))?|"
    r"session/(?:protocol|process|client|server)|broker)|robcl/(frames|arm|motion))/"
)
# The folders that all devices share are modules of their own.
SHARED_BY_DEVICES = ("drivers", "support", "arm")
GENERATED = re.compile(r"^(?:[\w]+/)*\w+_(types|json|calls|interface|client|server)\.[hc]pp$")

GENERATED_MODULES = {
    "types": "generated-types",
    "json": "generated-types",
    "calls": "generated-interfaces",
    "interface": "generated-interfaces",
    "client": "generated-stubs",
    "server": "generated-stubs",
}


@dataclass(frozen=True, slots=True)
class Module:
    """`knows` are the modules whose headers this module may include. `why` is the rule in words."""

    knows: frozenset[str]
    why: str


def _module(knows: str, why: str) -> Module:
    return Module(frozenset(knows.split()), why)


_BELOW_PROTOCOL = "base wire qos access crypto medium description"
_BELOW_SESSION = _BELOW_PROTOCOL + " generated-types generated-interfaces"
_SESSION = _BELOW_SESSION + " public"
_INWARDS = (
    "the modules of the session stand on each other: public, protocol, process, client, server"
)
_BY_CONTRACT = (
    "the session knows media by contract alone (core, medium, quiet, waiting and kinds.hpp), "
    "and generated types, never clients; "
)

_MEDIUM = (
    "a medium moves opaque bytes and knows no other: the contract, its registration and buffers"
)
_DEVICE = _BELOW_SESSION + " public umbrella frames generated-stubs"

MODULES: dict[str, Module] = {
    "base": _module("", "base stands on the standard library alone"),
    "wire": _module("base", "wire knows base alone"),
    "qos": _module("base", "qos knows base alone"),
    "access": _module("base", "access knows base alone: what it needs is passed in"),
    "audit": _module("base", "the audit knows base alone: what it writes is passed in"),
    "crypto": _module("base", "crypto knows base alone: bytes in, bytes out"),
    "medium": _module("base qos", "the contract of a medium speaks of bytes and quality alone"),
    "media": _module(
        "base medium media/layers media/shm",
        "kinds.cpp opens a medium and puts layers on it: what it offers is asked by contract",
    ),
    "media/buffers": _module("base medium", "buffers of media know base and the contract"),
    "media/layers": _module("base medium", "a layer knows the contract of what it is put on"),
    "media/sealed": _module(
        "base crypto medium media/buffers",
        "what seals a medium knows no medium: datagrams, crypto and buffers",
    ),
    "media/inproc": _module("base medium media media/buffers", _MEDIUM),
    "media/shm": _module("base medium media media/buffers", _MEDIUM),
    "media/lcm": _module("base crypto medium media media/buffers media/sealed", _MEDIUM),
    "media/testing": _module(
        "base medium media/buffers media/layers", "a faulty line is a layer for tests"
    ),
    "description": _module("base qos access", "a description knows status, quality and base alone"),
    "public": _module(_BELOW_SESSION, _BY_CONTRACT + _INWARDS),
    "session/protocol": _module(
        _BELOW_PROTOCOL + " public",
        "packets know no generated types: what travels in calls is coded by generated code alone",
    ),
    "session/process": _module(_SESSION + " session/protocol", _BY_CONTRACT + _INWARDS),
    "session/client": _module(
        _SESSION + " session/protocol session/process", _BY_CONTRACT + _INWARDS
    ),
    "session/server": _module(
        _SESSION + " audit session/protocol session/process session/client", _BY_CONTRACT + _INWARDS
    ),
    "umbrella": _module("base public", "gecos.hpp gathers what programs use: base and public"),
    "broker": _module(
        _BELOW_SESSION + " public umbrella generated-stubs",
        "the broker is an object like any other: public headers and generated code, no medium",
    ),
    "frames": _module("base wire", "robcl/frames knows neither session nor generated code"),
    "arm": _module("base wire frames", "robcl/arm knows no session, no generated code, no motion"),
    "motion": _module(
        "base wire frames arm", "robcl/motion knows no session and no generated code"
    ),
    "generated-types": _module(
        "base wire frames", "generated types know the codec and hand-written values"
    ),
    "generated-interfaces": _module(
        "base wire qos access description generated-types",
        "descriptions of interfaces and what calls take and give stand below the session",
    ),
    "generated-stubs": _module(
        _BELOW_SESSION + " frames public",
        "generated clients and servers know public headers and types",
    ),
    "devices/drivers": _module(
        "base frames arm", "a joint driver knows joints and hardware: no session, no generated code"
    ),
    "devices/support": _module(
        _DEVICE, "what every device needs knows no device: no medium, no broker, no arm"
    ),
    "devices/arm": _module(
        _DEVICE + " arm motion devices/drivers devices/support",
        "the servants of all arms know drivers and support, and no exact arm",
    ),
    "devices": _module(
        _DEVICE + " arm motion devices/drivers devices/support devices/arm",
        "a device is a generated skeleton, robcl and one piece of hardware: no medium, no broker",
    ),
    "binding": _module(
        _BELOW_SESSION + " audit public umbrella broker media/shm",
        "the binding sits on public headers and broker, at the byte seam: no generated client; "
        "of media it shows the runtime directory alone",
    ),
}


@dataclass(frozen=True, slots=True)
class Guest:
    """A library, or a module, that only some files may include."""

    header: re.Pattern[str]
    where: re.Pattern[str]
    name: str
    rule: str


INNER_MODULES = Guest(
    re.compile(r"^gecos/session/"),
    re.compile(r"^(runtime/cpp/gecos/session|tests/cpp/session|tests/fuzz|tests/stress)/"),
    "an inner module of the session",
    "the session and its tests know its modules; all others include the public headers in gecos/",
)
GUESTS = (
    INNER_MODULES,
    Guest(
        re.compile(r"^gecos/session/client/"),
        re.compile(
            r"^(?!runtime/cpp/gecos/session/server/(?!(server|registrar|broker_contact|zone_watch)\.))"
        ),
        "the client side",
        "the server is a client of the broker and of zones only: in server.cpp, registrar, "
        "broker_contact and zone_watch",
    ),
    Guest(
        re.compile(r"^lcm/"),
        re.compile(r"^runtime/cpp/gecos/media/lcm/port\.cpp$"),
        "LCM",
        "lcm.h appears in gecos/media/lcm/port.cpp alone",
    ),
    Guest(
        re.compile(r"^(kdl|kdl_parser|Eigen|eigen3|unsupported/Eigen|urdf\w*)/"),
        re.compile(r"^(runtime/cpp/robcl|devices)/"),
        "KDL, Eigen or urdfdom",
        "KDL, Eigen and urdfdom appear in robcl/ and devices/ alone",
    ),
    Guest(
        re.compile(r"^nanobind/"),
        re.compile(r"^runtime/python/extensions/"),
        "nanobind",
        "nanobind appears in runtime/python/extensions alone",
    ),
    Guest(
        re.compile(r"^Python\.h$"),
        re.compile(r"^runtime/python/extensions/"),
        "the Python C API",
        "C++ outside runtime/python/extensions never calls Python",
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
    Guest(
        re.compile(r"^toml\+\+/"),
        re.compile(r"^(devices/arm/arm_file|runtime/cpp/gecos/access/lab_file)\.cpp$"),
        "toml++",
        "toml++ appears in devices/arm/arm_file.cpp and gecos/access/lab_file.cpp alone",
    ),
)

PURE_MODULES = ("wire", "qos", "access", "crypto")
# The keys of a user are files. Only the source that reads and writes these files may do I/O.
KEY_KEEPER = "runtime/cpp/gecos/crypto/key_directory.cpp"
IMPURE_HEADER = re.compile(
    r"^(thread|mutex|shared_mutex|condition_variable|future|fstream|iostream|filesystem|"
    r"sys/.*|unistd\.h|poll\.h|fcntl\.h|pthread\.h|netinet/.*|arpa/.*|time\.h|ctime)$"
)
IMPURE_CALL = re.compile(r"\b(?:\w*[cC]lock::now|clock_gettime|gettimeofday)\s*\(")
PURE_RULE = "wire, qos, access and crypto do no I/O, own no thread and read no clock"


# The contents of calls are declared in .gidl files. Their codecs and descriptions are generated.
CALLING_MODULES = ("session/process", "session/client", "session/server", "broker")
CODED = re.compile(
    r"\.(?:put|put_string|put_count|get_string|get_count)\(|\.get\([^)]|"
    r"\b(?:get|put)_(?:block|sequence|optional|array|map)\(|\bdecode_enum\("
)
DESCRIBED = re.compile(r"(?<!const )\bOperationDescription(?: \w+)? ?[;{(=,]")
BY_HAND_RULE = (
    "calls, their results and the descriptions of operations are generated from idl/; packets are "
    "coded in session/protocol"
)


def module_of_file(path: str) -> str | None:
    """Returns the module of a file of the tree; None if the file has no module."""
    if path.startswith(tuple(root + "/" for root in PROGRAMS)):
        return PROGRAM
    if path.startswith("runtime/python/extensions/"):
        return "binding"
    if path.startswith("devices/"):
        return module_of_header(path)
    for root in ("runtime/cpp/", "generated/cpp/"):
        if path.startswith(root):
            return module_of_header(path.removeprefix(root))
    return None


def module_of_header(header: str) -> str | None:
    """Returns the module of a header, given as in an #include; None for a foreign header."""
    if header.startswith("devices/"):
        folder = header.split("/")[1]
        return f"devices/{folder}" if folder in SHARED_BY_DEVICES else "devices"
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
        return GENERATED_MODULES[generated[1]]
    return None


def files(tree: Path) -> Iterator[Path]:
    for root in ROOTS:
        for path in sorted((tree / root).rglob("*")):
            if path.suffix in SUFFIXES and path.is_file():
                yield path


def violations(path: str, text: str) -> list[Violation]:
    module = module_of_file(path)
    if module is None:
        return [
            Violation(
                path,
                1,
                "this file stands in no module",
                "every C++ file of runtime/ and devices/ has a module in docs/architecture.md",
                "move it into a module, or add its module to MODULES in tools/layers_cpp.py",
            )
        ]
    found: list[Violation] = []
    for number, line in enumerate(text.splitlines(), start=1):
        include = INCLUDE.match(line)
        if include:
            found += _include(path, number, module, include[2])
        elif _by_hand(module, line.split("//")[0]):
            found.append(
                Violation(
                    path,
                    number,
                    f"{module} codes fields, or describes an operation, by hand",
                    BY_HAND_RULE,
                    "declare it in idl/gecos and use what gidl generates for its calls",
                )
            )
        elif module in PURE_MODULES and IMPURE_CALL.search(line.split("//")[0]):
            found.append(
                Violation(
                    path,
                    number,
                    f"{module} reads a clock",
                    PURE_RULE,
                    "take the time as an argument",
                )
            )
    return found


def _by_hand(module: str, code: str) -> bool:
    """Returns whether a line codes the contents of a call, or describes an operation."""
    if module in CALLING_MODULES and CODED.search(code):
        return True
    return module in (*CALLING_MODULES, "session/protocol") and bool(DESCRIBED.search(code))


def _include(path: str, line: int, module: str, header: str) -> list[Violation]:
    for guest in (INNER_MODULES,) if module == PROGRAM else GUESTS:
        if guest.header.match(header) and not guest.where.match(path):
            return [
                Violation(
                    path,
                    line,
                    f"<{header}>: {guest.name} has no place here",
                    guest.rule,
                    "use what the module that owns it offers, or extend that module",
                )
            ]
    if module in PURE_MODULES and path != KEY_KEEPER and IMPURE_HEADER.match(header):
        return [
            Violation(
                path,
                line,
                f"<{header}> in {module}",
                PURE_RULE,
                "let the caller do it and pass the result in",
            )
        ]
    target = module_of_header(header)
    if module == PROGRAM:
        return []
    allowed = MODULES[module].knows
    if target is None or target == module or target in allowed:
        return []
    choice = ", ".join(sorted(allowed)) or "nothing of ours"
    return [
        Violation(
            path,
            line,
            f'{module} includes "{header}" of {target}',
            MODULES[module].why,
            f"it may include {choice}: pass in what it needs, or move the code to one that may",
        )
    ]
