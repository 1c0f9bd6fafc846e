"""The pieces of code in docs/programs.md compile, each as a function of its own."""

import re
from pathlib import Path
from textwrap import indent

from blocks import blocks, check_python, compile_cpp

PROGRAMS = "docs/programs.md"

CPP_BEFORE = """\
#include <iostream>

#include "camera_server.hpp"
#include "gecos/gecos.hpp"
#include "gecos/reconnecting.hpp"
#include "gecos/serve.hpp"
#include "oven_client.hpp"
#include "oven_server.hpp"

using namespace std::chrono_literals;
template <class Error>
int fail(const Error& error) {
  std::cerr << error << std::endl;
  return 1;
}
using Oven = tl::expected<plant::Oven, gecos::CreateError>;
using Robot = Oven;  // anything that can be held
template <class Octets>
void fill(Octets) {}
"""

PYTHON_BEFORE = """\
import asyncio
import threading
import time
import gecos
import numpy
from camera import CameraServant, Image
from oven import Oven, OvenServant, TooHot
from robcl.frames import Frame, mm, translate
from robcl.manipulator import Blend, Configuration, Manipulator, PathType, Trajectory, Wrist

def thermocouple() -> float:
    return 293.0

frame = numpy.zeros((1080, 1920, 3), numpy.uint8)
"""


def test_the_cpp_compiles(generated: Path, tmp_path: Path) -> None:
    functions = [
        f"class Piece{at} : lab::CameraServant {{\n  int piece() {{\n{block}  return 0;\n}}\n}};\n"
        if "lend_picture" in block
        else f"[[maybe_unused]] int piece_{at}([[maybe_unused]] Oven& oven, "
        f"[[maybe_unused]] Robot& robot, [[maybe_unused]] gecos::Lab& lab, "
        f"[[maybe_unused]] plant::OvenServant& servant) {{\n{block}  return 0;\n}}\n"
        for at, block in enumerate(blocks(PROGRAMS, "cpp"))
    ]
    compile_cpp(CPP_BEFORE + "".join(functions), generated, tmp_path)


def test_the_python_is_well_typed(generated: Path, tmp_path: Path) -> None:
    functions = []
    for at, block in enumerate(blocks(PROGRAMS, "python")):
        kind = "OvenServant" if re.search(r"gecos\.(Server|serve)\(", block) else "Oven"
        head = (
            f"def piece_{at}(oven: {kind}, robot: Manipulator, goal: Frame, "
            "camera: CameraServant, lab: gecos.Lab) -> None:\n"
        )
        functions.append(head + indent(block, "    "))
    check_python(PYTHON_BEFORE + "\n".join(functions), generated, tmp_path)
