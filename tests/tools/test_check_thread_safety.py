"""The thread-safety check finds members that are touched without their mutex."""

from pathlib import Path

import check_thread_safety
import pytest

FLAGS = (f"-I{check_thread_safety.TREE / 'runtime/cpp'}", "-std=c++20")

COUNTER = """#pragma once
#include "gecos/base/mutex.hpp"

struct Counter {
  void add() GECOS_REQUIRES(mutex);
  int locked();
  gecos::Mutex mutex;
  int count GECOS_GUARDED_BY(mutex) = 0;
};
"""
RIGHT = """#include "counter.hpp"
void Counter::add() { ++count; }
int Counter::locked() {
  const gecos::MutexLock lock(mutex);
  add();
  return count;
}
"""


def check(folder: Path, source: str) -> list[str]:
    (folder / "counter.hpp").write_text(COUNTER, encoding="utf-8")
    file = folder / "counter.cpp"
    file.write_text(source, encoding="utf-8")
    return check_thread_safety.check_alike((*FLAGS, f"-I{folder}"), [file], folder)


def test_passes_what_holds_the_mutex(tmp_path: Path) -> None:
    assert check(tmp_path, RIGHT) == [""]


@pytest.mark.parametrize(
    ("instead", "says"),
    [
        ("", "calling function 'add' requires holding mutex 'mutex'"),
        (
            "  { const gecos::MutexLock lock(mutex); }\n",
            "reading variable 'count' requires holding mutex 'mutex'",
        ),
    ],
)
def test_names_what_is_touched_without_it(tmp_path: Path, instead: str, says: str) -> None:
    wrong = RIGHT.replace("  const gecos::MutexLock lock(mutex);\n", instead)
    (text,) = check(tmp_path, wrong)
    assert says in text


def test_names_a_source_whose_header_only_another_source_includes(tmp_path: Path) -> None:
    (tmp_path / "counter.hpp").write_text(COUNTER, encoding="utf-8")
    complete, incomplete = tmp_path / "complete.cpp", tmp_path / "incomplete.cpp"
    complete.write_text('#include "counter.hpp"\nCounter first;\n', encoding="utf-8")
    incomplete.write_text("Counter second;\n", encoding="utf-8")
    flags = (*FLAGS, f"-I{tmp_path}")
    nothing, text = check_thread_safety.check_alike(flags, [complete, incomplete], tmp_path)
    assert nothing == ""
    assert "unknown type name 'Counter'" in text


def test_a_header_that_a_macro_of_its_source_adapts_is_not_precompiled() -> None:
    source = "#include <map>\n\n#define TOML_EXCEPTIONS 0\n#include <toml++/toml.h>\n"
    assert check_thread_safety.foreign_headers(source) == {"#include <map>"}
