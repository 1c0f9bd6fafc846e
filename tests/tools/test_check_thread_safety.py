"""The thread-safety check finds members that are touched without their mutex."""

import json
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
    return check_thread_safety.check_alike((*FLAGS, f"-I{folder}"), [[file]], folder)


def test_passes_what_holds_the_mutex(tmp_path: Path) -> None:
    assert check(tmp_path, RIGHT) == []


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


def test_names_the_one_source_of_several_groups_that_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "counter.hpp").write_text(COUNTER, encoding="utf-8")
    local = '#include "counter.hpp"\nnamespace {\nint twice() { return 2; }\n}\n'
    texts = {
        "first": RIGHT,
        "second": local,
        "third": f"{local}int third() {{ return twice(); }}\n",
    }
    texts["wrong"] = '#include "counter.hpp"\nint wrong(Counter& it) { return it.count; }\n'
    for name, text in texts.items():
        (tmp_path / f"{name}.cpp").write_text(text, encoding="utf-8")
    # The second and the third have a local name in common, so they do not compile together.
    groups = [[tmp_path / "first.cpp"], [tmp_path / f"{name}.cpp" for name in list(texts)[1:]]]
    flags = (*FLAGS, f"-I{tmp_path}")
    (text,) = check_thread_safety.check_alike(flags, groups, tmp_path)
    assert "wrong.cpp:2:" in text


def test_checks_each_source_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tree, build = tmp_path / "tree", tmp_path / "build"
    (tree / "runtime").mkdir(parents=True)
    (tree / "devices").mkdir()
    build.mkdir()
    commands = []
    for target, count in (("one", 9), ("other", 3)):
        for nth in range(count):
            file = tree / "runtime" / f"{target}{nth}.cpp"
            file.write_text('#include "gecos/base/mutex.hpp"\n', encoding="utf-8")
            command = f"c++ -std=c++20 -o runtime/{target}.dir/{nth}.o -c {file}"
            commands.append({"file": str(file), "command": command})
    (build / "compile_commands.json").write_text(json.dumps(commands), encoding="utf-8")
    monkeypatch.setattr(check_thread_safety, "TREE", tree)
    (groups,) = check_thread_safety.sources(build).values()
    assert [len(group) for group in groups] == [8, 1, 3]
    assert {file for group in groups for file in group} == set((tree / "runtime").iterdir())


def test_follows_a_header_that_has_a_mutex_to_the_sources_that_include_it() -> None:
    found = check_thread_safety.headers_with_mutexes()
    assert "gecos/session/server/host_state.hpp" in found
    assert "gecos/wire/packet.hpp" not in found


@pytest.mark.parametrize(
    "kind", ["std::mutex", "std::recursive_mutex", "std::shared_mutex", "std::shared_timed_mutex"]
)
@pytest.mark.parametrize("path", ["runtime/cpp/gecos/media/queue.hpp", "devices/arm/arm.cpp"])
def test_names_a_mutex_that_the_analysis_does_not_see(tmp_path: Path, kind: str, path: str) -> None:
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    source = f"// no {kind} here\nclass Queue {{\n  mutable {kind} mutex_;\n}};\n"
    file.write_text(source, encoding="utf-8")
    (text,) = check_thread_safety.plain_mutexes(tmp_path)
    assert text.startswith(f"{path}:3: error: {kind}: ")
    assert "use gecos::Mutex of gecos/base/mutex.hpp" in text


def test_only_our_mutex_is_made_of_one_of_the_standard_library(tmp_path: Path) -> None:
    for path in ("runtime/cpp/gecos/base/mutex.hpp", "tests/cpp/media/pair_medium.cpp"):
        file = tmp_path / path
        file.parent.mkdir(parents=True)
        file.write_text("std::mutex mutex;\n", encoding="utf-8")
    assert check_thread_safety.plain_mutexes(tmp_path) == []
