"""The check of includes finds a header that only another source of a united build includes."""

from pathlib import Path

import check_includes

UNITS = "constexpr double in_deg(double radians) { return radians * 57.3; }\n"
CALLS = "double shown(double angle) {\n  return in_deg(angle);\n}\n"


def missing(folder: Path, **sources: str) -> list[str]:
    motion = folder / "runtime" / "cpp" / "motion"
    motion.mkdir(parents=True)
    (motion / "units.hpp").write_text(UNITS)
    (motion / "through.hpp").write_text('#include "motion/units.hpp"\n')
    for name, text in sources.items():
        (motion / f"{name}.cpp").write_text(text)
    return check_includes.violations(folder)[1]


def test_names_the_function_and_its_header(tmp_path: Path) -> None:
    (found,) = missing(tmp_path, model=CALLS, line='#include "motion/units.hpp"\n' + CALLS)
    assert found == (
        "runtime/cpp/motion/model.cpp: calls in_deg, but does not include "
        "runtime/cpp/motion/units.hpp"
    )


def test_a_header_may_be_included_through_another(tmp_path: Path) -> None:
    assert missing(tmp_path, model='#include "motion/through.hpp"\n' + CALLS) == []


def test_members_local_names_and_texts_are_no_calls_of_the_free_function(tmp_path: Path) -> None:
    member = (
        "struct Angle {\n  double in_deg() const;\n};\ndouble of(Angle a) { return a.in_deg(); }\n"
    )
    local = "double of() {\n  const auto in_deg = [] { return 1.0; };\n  return in_deg();\n}\n"
    text = '// in_deg(angle)\nconst char* const help = "in_deg(angle)";\n'
    assert missing(tmp_path, member=member, local=local, text=text) == []
