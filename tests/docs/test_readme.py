"""The README's example is real: its interface compiles, and so does what uses it."""

from pathlib import Path

from blocks import blocks, check_python, compile_cpp

CPP_AROUND = """\
#include <chrono>
#include <iostream>

#include "gecos/gecos.hpp"
#include "oven_client.hpp"

using namespace std::chrono_literals;

template <class Error>
int fail(const Error& error) {{
  std::cerr << error << std::endl;
  return 1;
}}

int main() {{
{block}
  return warm ? 0 : fail(warm.error());
}}
"""

PYTHON_AROUND = """\
import gecos
from oven import Oven

{block}
"""


def test_the_interface_has_ten_lines() -> None:
    assert len(blocks("README.md", "idl")[0].splitlines()) == 10


def test_the_cpp_compiles(generated: Path, tmp_path: Path) -> None:
    (block,) = blocks("README.md", "cpp")
    compile_cpp(CPP_AROUND.format(block=block), generated, tmp_path)


def test_the_python_is_well_typed(generated: Path, tmp_path: Path) -> None:
    (block,) = blocks("README.md", "python")
    check_python(PYTHON_AROUND.format(block=block), generated, tmp_path)
