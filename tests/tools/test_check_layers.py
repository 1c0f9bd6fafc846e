"""The layer check finds what is planted, and nothing else."""

from pathlib import Path

import check_layers
import layers_cpp
import layers_python
import pytest
from layers_rule import Violation


def cpp(path: str, text: str) -> list[Violation]:
    return layers_cpp.violations(path, text)


def python(path: str, text: str) -> list[Violation]:
    return layers_python.violations(path, text)


@pytest.mark.parametrize(
    ("path", "header"),
    [
        ("runtime/cpp/gecos/base/ids.hpp", '"gecos/wire/encoder.hpp"'),
        ("runtime/cpp/gecos/wire/packet.cpp", '"gecos/media/medium.hpp"'),
        ("runtime/cpp/gecos/qos/match.cpp", '"gecos/media/medium.hpp"'),
        ("runtime/cpp/gecos/access/lease_table.cpp", '"gecos/command.hpp"'),
        ("runtime/cpp/gecos/access/lease_table.cpp", '"gecos/object_types.hpp"'),
        ("runtime/cpp/gecos/media/buffers/ring.cpp", '"gecos/wire/encoder.hpp"'),
        ("runtime/cpp/gecos/media/inproc/inproc.cpp", '"gecos/access/status.hpp"'),
        ("runtime/cpp/gecos/media/buffers/ring.cpp", '"gecos/media/shm/memory.hpp"'),
        ("runtime/cpp/gecos/media/sealed/sender.cpp", '"gecos/media/lcm/port.hpp"'),
        ("runtime/cpp/gecos/media/shm/connection.cpp", '"gecos/media/sealed/sender.hpp"'),
        ("runtime/cpp/gecos/media/layers/fragments.cpp", '"gecos/media/lcm/lcm.hpp"'),
        ("runtime/cpp/gecos/media/lcm/network.cpp", '"gecos/media/testing/faulty.hpp"'),
        ("runtime/cpp/gecos/session/client/select.cpp", '"gecos/media/lcm/lcm.hpp"'),
        ("runtime/cpp/gecos/session/client/select.cpp", '"gecos/media/shm/connection.hpp"'),
        ("runtime/cpp/gecos/session/client/lookup.cpp", '"gecos/broker_client.hpp"'),
        ("runtime/cpp/gecos/session/client/lookup.cpp", '"robcl/frames/frame.hpp"'),
        ("runtime/cpp/gecos/broker/broker.cpp", '"gecos/media/inproc/inproc.hpp"'),
        ("runtime/cpp/robcl/frames/frame.cpp", '"gecos/command.hpp"'),
        ("runtime/cpp/robcl/arm/chain.cpp", '"robcl/motion/straight.hpp"'),
        ("runtime/cpp/robcl/motion/straight.cpp", '"robcl/manipulator_types.hpp"'),
        ("generated/cpp/robcl/gripper_types.cpp", '"gecos/command.hpp"'),
        ("generated/cpp/robcl/gripper_client.cpp", '"gecos/media/inproc/inproc.hpp"'),
        ("devices/rx90/server.cpp", '"gecos/media/buffers/ring.hpp"'),
        ("devices/rx90/server.cpp", '"gecos/broker/broker.hpp"'),
        ("devices/drivers/simulated_driver.cpp", '"gecos/gecos.hpp"'),
        ("devices/drivers/simulated_driver.cpp", '"devices/arm/arm_controller.hpp"'),
        ("devices/support/carrier.cpp", '"devices/arm/arm_device.hpp"'),
        ("devices/arm/arm_program.cpp", '"devices/rx90/rx90_urdf.hpp"'),
        ("devices/arm/arm_program.cpp", '"gecos/broker/broker.hpp"'),
        ("runtime/python/extensions/core.cpp", '"robcl/gripper_client.hpp"'),
        ("runtime/cpp/gecos/lab.hpp", '"gecos/session/client/context.hpp"'),
        ("runtime/cpp/gecos/session/protocol/packets.hpp", '"gecos/session/process/runtime.hpp"'),
        ("runtime/cpp/gecos/session/protocol/codec.hpp", '"gecos/object_types.hpp"'),
        ("runtime/cpp/gecos/session/protocol/codec.hpp", '"gecos/broker_interface.hpp"'),
        ("runtime/cpp/gecos/session/process/runtime.cpp", '"gecos/session/client/connect.hpp"'),
        ("runtime/cpp/gecos/session/client/lab.cpp", '"gecos/session/server/io_loop.hpp"'),
        ("runtime/cpp/gecos/session/client/lab.cpp", '"gecos/gecos.hpp"'),
        ("runtime/cpp/gecos/session/server/io_loop.cpp", '"gecos/session/client/connect.hpp"'),
        ("runtime/cpp/gecos/session/server/server_call.cpp", '"gecos/session/client/connect.hpp"'),
        ("runtime/cpp/gecos/gecos.hpp", '"gecos/session/process/runtime.hpp"'),
        ("runtime/cpp/gecos/broker/others.cpp", '"gecos/session/client/context.hpp"'),
        ("runtime/python/extensions/client.cpp", '"gecos/session/client/context.hpp"'),
        ("generated/cpp/robcl/gripper_client.cpp", '"gecos/session/protocol/packets.hpp"'),
        ("devices/rx90/server.cpp", '"gecos/session/process/termination_signals.hpp"'),
        ("examples/grip_block.cpp", '"gecos/session/process/termination_signals.hpp"'),
        ("benchmarks/ours.cpp", '"gecos/session/protocol/packets.hpp"'),
        ("tests/cpp/broker/broker_test.cpp", '"gecos/session/server/server_call.hpp"'),
        ("runtime/cpp/gecos/media/lcm/network.cpp", "<lcm/lcm.h>"),
        ("runtime/cpp/gecos/session/client/select.cpp", "<Eigen/Dense>"),
        ("runtime/cpp/gecos/wire/encoder.hpp", "<kdl/frames.hpp>"),
        ("runtime/cpp/gecos/command.hpp", "<nanobind/nanobind.h>"),
        ("runtime/cpp/gecos/command.hpp", "<Python.h>"),
        ("runtime/cpp/gecos/command.hpp", "<sodium.h>"),
        ("runtime/cpp/gecos/command.hpp", "<nlohmann/json.hpp>"),
        ("devices/arm/arm_program.cpp", "<toml++/toml.h>"),
        ("runtime/cpp/gecos/access/access_policy.cpp", "<toml++/toml.h>"),
        ("generated/cpp/robcl/gripper_json.cpp", '"robcl/gripper_client.hpp"'),
        ("runtime/cpp/gecos/wire/encoder.hpp", "<thread>"),
        ("runtime/cpp/gecos/access/lease_table.cpp", "<sys/socket.h>"),
        ("runtime/cpp/gecos/crypto/transport.cpp", "<fcntl.h>"),
        ("runtime/cpp/gecos/crypto/key_directory.hpp", "<unistd.h>"),
        ("runtime/cpp/gecos/crypto/handshake_initiator.cpp", '"gecos/wire/encoder.hpp"'),
        ("runtime/cpp/gecos/media/sealed/sender.cpp", "<sodium.h>"),
    ],
)
def test_a_forbidden_include_is_found(path: str, header: str) -> None:
    (violation,) = cpp(path, f"#pragma once\n#include <vector>\n  #  include {header}\n")
    assert violation.line == 3
    assert violation.path == path
    assert header.strip('"<>') in violation.what
    assert violation.rule
    assert violation.do


@pytest.mark.parametrize(
    ("path", "header"),
    [
        ("runtime/cpp/gecos/wire/packet.cpp", '"gecos/base/bytes.hpp"'),
        ("runtime/cpp/gecos/media/lcm/port.cpp", "<lcm/lcm.h>"),
        ("runtime/cpp/gecos/media/sealed/responder.cpp", '"gecos/crypto/channel.hpp"'),
        ("runtime/cpp/gecos/media/lcm/network.cpp", '"gecos/media/sealed/network.hpp"'),
        ("runtime/cpp/gecos/session/server/io_loop.hpp", '"gecos/media/waiting.hpp"'),
        ("runtime/cpp/gecos/crypto/keys.cpp", "<sodium.h>"),
        ("runtime/cpp/gecos/crypto/key_directory.cpp", "<fcntl.h>"),
        ("runtime/cpp/gecos/media/shm/memory.cpp", '"gecos/media/medium.hpp"'),
        ("runtime/cpp/gecos/media/shm/memory.cpp", "<sys/mman.h>"),
        ("runtime/cpp/gecos/session/client/select.cpp", '"gecos/media/medium.hpp"'),
        ("runtime/cpp/gecos/builtin_operations.hpp", '"gecos/object_types.hpp"'),
        ("runtime/cpp/gecos/broker/broker.hpp", '"gecos/broker_server.hpp"'),
        ("runtime/cpp/gecos/session/protocol/packets.hpp", '"gecos/command.hpp"'),
        ("runtime/cpp/gecos/session/process/runtime.hpp", '"gecos/session/protocol/handshake.hpp"'),
        ("runtime/cpp/gecos/session/client/lab.cpp", '"gecos/session/process/runtime.hpp"'),
        ("runtime/cpp/gecos/session/server/server.cpp", '"gecos/session/client/context.hpp"'),
        (
            "runtime/cpp/gecos/session/server/registrar.hpp",
            '"gecos/session/client/broker_client.hpp"',
        ),
        ("tests/cpp/session/create_test.cpp", '"gecos/session/client/select.hpp"'),
        ("tests/cpp/session/json_test.cpp", "<nlohmann/json.hpp>"),
        ("runtime/cpp/robcl/arm/chain.cpp", "<kdl/chain.hpp>"),
        ("devices/rx90/server.cpp", '"robcl/rx90_server.hpp"'),
        ("devices/rx90/server.cpp", '"devices/arm/arm_program.hpp"'),
        ("devices/arm/arm_program.cpp", '"devices/support/device_main.hpp"'),
        ("devices/drivers/joint_driver.hpp", '"robcl/arm/joint_values.hpp"'),
        ("devices/rx90/server.cpp", "<urdf_parser/urdf_parser.h>"),
        ("devices/arm/arm_file.cpp", "<toml++/toml.h>"),
        ("runtime/cpp/gecos/access/lab_file.cpp", "<toml++/toml.h>"),
        ("generated/cpp/robcl/device_types.hpp", '"robcl/frames/frame.hpp"'),
        ("generated/cpp/robcl/device_client.hpp", '"gecos/object.hpp"'),
        ("generated/cpp/robcl/gripper_json.cpp", '"gecos/wire/json_shapes.hpp"'),
        ("runtime/cpp/gecos/wire/json.hpp", "<nlohmann/json.hpp>"),
        ("runtime/python/extensions/core.cpp", "<nanobind/nanobind.h>"),
        ("runtime/cpp/gecos/base/result.hpp", "<tl/expected.hpp>"),
    ],
)
def test_an_allowed_include_passes(path: str, header: str) -> None:
    assert cpp(path, f"#include {header}\n") == []


def test_a_pure_module_that_reads_a_clock_is_found_but_not_in_a_comment() -> None:
    path = "runtime/cpp/gecos/access/lease_table.cpp"
    (violation,) = cpp(
        path, "// std::chrono::steady_clock::now() is the caller's\nauto t = Clock::now();\n"
    )
    assert violation.line == 2
    assert "take the time as an argument" in violation.do


@pytest.mark.parametrize(
    "path",
    [
        "runtime/cpp/gecos/helpers/util.hpp",
        "runtime/cpp/gecos/util.hpp",
        "runtime/cpp/gecos/session/util.hpp",
        "runtime/cpp/gecos/session/helpers/util.hpp",
    ],
)
def test_a_file_in_no_module_is_found(path: str) -> None:
    (violation,) = cpp(path, "#pragma once\n")
    assert "no module" in violation.what


@pytest.mark.parametrize(
    ("path", "statement", "named"),
    [
        ("codegen/gidl/model/types.py", "from gidl.wire import wire_layout", "gidl.wire"),
        ("codegen/gidl/model/types.py", "from ..syntax.tree import Struct", "gidl.syntax.tree"),
        ("codegen/gidl/syntax/parser.py", "import gidl.resolve.files", "gidl.resolve"),
        ("codegen/gidl/resolve/types.py", "from gidl.wire import hashes", "gidl.wire"),
        (
            "codegen/gidl/wire/wire_layout.py",
            "from ..targets.cpp import view",
            "gidl.targets.cpp",
        ),
        ("codegen/gidl/rules/unit.py", "from ..syntax.parser import parse", "gidl.syntax.parser"),
        (
            "codegen/gidl/targets/cpp/view.py",
            "from gidl.syntax.tree import Struct",
            "gidl.syntax.tree",
        ),
        ("codegen/gidl/targets/cpp/lowering.py", "import jinja2", "jinja2"),
        ("codegen/gidl/cli/main.py", "import jinja2", "jinja2"),
        ("codegen/gidl/cli/main.py", "import gecos", "gecos"),
        ("codegen/gidl/targets/emit.py", "import numpy as np", "numpy"),
        ("runtime/python/gecos/wire/decode.py", "from gecos import command", "gecos.command"),
        ("runtime/python/gecos/wire/decode.py", "from .. import _core", "gecos._core"),
        ("runtime/python/gecos/command.py", "import robcl.frames", "robcl.frames"),
        ("runtime/python/gecos/command.py", "import lcm", "lcm"),
        ("runtime/python/gecos/command.py", "from rich import print", "rich"),
        ("runtime/python/robcl/frames/frame.py", "from gecos import lab", "gecos.lab"),
        (
            "runtime/python/robcl/frames/frame.py",
            "from robcl.gripper import Gripper",
            "robcl.gripper",
        ),
        ("generated/python/robcl/gripper_types.py", "from gecos.command import X", "gecos.command"),
        ("generated/python/robcl/gripper.py", "from gecos._core import call", "gecos._core"),
    ],
)
def test_a_forbidden_import_is_found(path: str, statement: str, named: str) -> None:
    (violation,) = python(path, f'"""Doc."""\n\ndef late() -> None:\n    {statement}\n')
    assert violation.line == 4
    assert named in violation.what
    assert violation.rule
    assert violation.do


@pytest.mark.parametrize(
    ("path", "statement"),
    [
        ("codegen/gidl/syntax/parser.py", "from gidl.syntax.tree import Struct"),
        ("codegen/gidl/targets/emit.py", "import jinja2"),
        ("codegen/gidl/cli/main.py", "from gidl import resolve, targets"),
        ("codegen/gidl/targets/cpp/lowering.py", "from gidl.targets.cpp.view import File"),
        ("runtime/python/gecos/wire/codes.py", "import numpy as np, struct"),
        ("runtime/python/gecos/command.py", "from gecos import _core"),
        ("runtime/python/gecos/cli/main.py", "import click"),
        ("runtime/python/robcl/frames/__init__.py", "from .frame import Frame"),
        ("generated/python/robcl/gripper_types.py", "from robcl.frames import Frame"),
        ("generated/python/robcl/gripper_types.py", "from gecos.wire import Decoder"),
        ("generated/python/robcl/gripper.py", "from gecos import Command"),
        ("generated/python/robcl/gripper.py", "from .gripper_types import GripperState"),
    ],
)
def test_an_allowed_import_passes(path: str, statement: str) -> None:
    assert python(path, statement) == []


@pytest.mark.parametrize(
    "text", ['_PING = Operation(3, "ping")', 'PING = interface.Operation(3, "ping")']
)
def test_an_operation_described_in_python_is_found(text: str) -> None:
    (violation,) = python("runtime/python/gecos/builtin_operations.py", f"{text}\n")
    assert "by hand" in violation.what
    assert python("runtime/python/gecos/interface.py", f"{text}\n") == []
    assert python("generated/python/gecos_idl/object.py", f"{text}\n") == []


@pytest.mark.parametrize(
    "line",
    [
        'if (!from.get(epoch, "epoch")) return;',
        "to.put(static_cast<std::int32_t>(wanted));",
        "if (!password.empty()) to.put_string(password);",
        'if (wire::get_block(from, entry, "entry")) return entry;',
        "put_block(to, entry);",
        'decode_enum(from, wanted, "wanted") &&',
        "OperationDescription operation;",
        "const auto made = OperationDescription{};",
        "std::array<OperationDescription, 9> operations;",
    ],
)
def test_a_hand_written_codec_or_description_of_a_call_is_found(line: str) -> None:
    path = "runtime/cpp/gecos/session/client/broker_client.cpp"
    (violation,) = cpp(path, f"#pragma once\n{line}\n")
    assert violation.line == 2
    assert "by hand" in violation.what
    assert "idl/gecos" in violation.do


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("session/client/builtin_calls.cpp", "const auto result = described.get();"),
        ("session/client/context.cpp", "void call(const OperationDescription& operation);"),
        ("session/server/object_host.cpp", "const OperationDescription* const asked = find(code);"),
        ("session/client/own_call.hpp", "[&](wire::Encoder& to) { arguments.encode(to); }, {});"),
        ("session/protocol/handshake.cpp", "to.put_string(user);"),
    ],
)
def test_generated_codecs_and_packets_pass(path: str, line: str) -> None:
    assert cpp(f"runtime/cpp/gecos/{path}", f"{line}\n") == []


def test_the_report_says_where_what_why_and_what_to_do(tmp_path: Path) -> None:
    planted = tmp_path / "runtime/cpp/gecos/session/client/select.cpp"
    planted.parent.mkdir(parents=True)
    planted.write_text('#include "gecos/media/lcm/lcm.hpp"\n')
    assert check_layers.report(*check_layers.check(tmp_path)) == (
        "runtime/cpp/gecos/session/client/select.cpp:1: error: "
        'session/client includes "gecos/media/lcm/lcm.hpp" of media/lcm\n'
        "    = rule: the session knows media by contract alone (core, medium, quiet, "
        "waiting and kinds.hpp), and generated types, never clients; the modules of the session "
        "stand on each other: public, protocol, process, client, server\n"
        "    = help: it may include access, base, crypto, description, generated-interfaces, "
        "generated-types, medium, public, qos, session/process, session/protocol, wire: "
        "pass in what it needs, or move the code to one that may\n"
        "check_layers: 1 files, 1 violations"
    )


def test_the_tree_itself_is_clean() -> None:
    files, violations = check_layers.check(check_layers.TREE)
    assert files > 0
    assert [str(violation) for violation in violations] == []
