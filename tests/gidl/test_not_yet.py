"""`gidl check` warns about annotations that do not act in this version."""

import re
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.compile import compile_files
from gidl.diagnostics.findings import Findings
from gidl.model.policy import Qos
from gidl.rules import not_yet

IDL = Path(__file__).parents[2] / "idl"

TEXT = """@final struct Image { @bulk sequence<octet> pixels; };
@qos(class=TIME_INDEPENDENT, latency="5ms", media="shm|lcm", deadline="1s")
interface Arm {
  @actor @idempotent @on_new("blend") @presence(FALSE)
  void move(@bulk in sequence<octet> path);
  @sensor @idempotent @qos(deadline="1s")
  long fine();
  @actor @on_new("queue") @qos(start_by="1s", liveliness=MANUAL, lifespan="1s")
  void also();
  @sensor @stream(rate="10Hz") @open_stream @qos(reliability=BEST_EFFORT, depth=4, deadline="1s")
  readonly attribute Image state;
  @actor @stream(dir="in", watchdog="8ms") @qos(deadline="1s", lifespan="1s", liveliness=MANUAL)
  attribute double speed;
};
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.gidl").write_text(TEXT)
    return tmp_path


def terms(said: str) -> set[tuple[int, str]]:
    found = re.findall(r"^\S+?:(\d+):\d+: warning\[G0708\]: '(\S+)' of", said, re.MULTILINE)
    return {(int(line), term) for line, term in found}


def test_each_term_that_does_not_act_is_named_where_it_is_written(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "a.gidl"]) == 0
    assert terms(capsys.readouterr().err) == {
        (2, "@qos(latency)"),
        (4, "@idempotent"),
        (5, "@bulk"),
        (8, "@qos(liveliness)"),
        (8, "@qos(lifespan)"),
        (10, "@qos(reliability)"),
        (12, "@qos(deadline)"),
    }


@pytest.mark.parametrize(
    "members",
    [
        "@bulk sequence<double> points;",
        "@bulk octet pixels[8];",
        "@optional @bulk sequence<octet> pixels;",
        "@max(9) @bulk sequence<octet> pixels;",
        "@bulk sequence<octet> left; @bulk sequence<octet> right;",
        "@bulk sequence<octet> pixels; sequence<Inner> parts;",
    ],
)
def test_bulk_acts_only_on_the_one_octet_sequence_of_the_struct_of_a_stream(
    here: Path, capsys: pytest.CaptureFixture[str], members: str
) -> None:
    (here / "b.gidl").write_text(
        "@final struct Inner { @bulk sequence<octet> raw; };\n"
        f"@final struct Image {{ {members} }};\n"
        "interface Camera { @sensor @stream readonly attribute Image state; };\n"
    )
    assert main(["check", "b.gidl"]) == 0
    assert (2, "@bulk") in terms(capsys.readouterr().err)


def test_bulk_does_not_act_on_the_parameters_of_an_event(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "b.gidl").write_text(
        "interface Camera { @event oneway void shot(@bulk in sequence<octet> pixels); };\n"
    )
    assert main(["check", "b.gidl"]) == 0
    assert terms(capsys.readouterr().err) == {(1, "@bulk")}
    assert main(["gen", "b.gidl", "--out", "out"]) == 0
    written = [path.read_text() for path in (here / "out").rglob("*") if path.is_file()]
    assert not any("lend_shot" in text for text in written)


def test_the_warning_may_be_excepted_and_strict_makes_it_an_error(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "--strict", "a.gidl"]) == 100
    assert "error[G0708]" in capsys.readouterr().err
    assert main(["check", "--strict", "--except", "G0708", "a.gidl"]) == 0
    (here / "gidl.toml").write_text('roots = ["."]\nstrict = true\nexcept = ["G0708"]\n')
    assert main(["check"]) == 0


def test_included_files_are_not_spoken_of(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "b.gidl").write_text('#include "a.gidl"\n@final struct Two { Image left, right; };\n')
    assert main(["check", "b.gidl"]) == 0
    assert "G0708" not in capsys.readouterr().err


def test_our_own_interfaces_ask_for_this_much_that_is_to_come() -> None:
    files = sorted(str(p) for p in IDL.rglob("*.gidl"))
    findings = Findings()
    not_yet.check(compile_files(files, [str(IDL)]).model, findings)
    asked = {(f.location.file, f.message.split("'")[1]) for f in findings.found if f.location}
    assert asked == {("robcl/manipulator.gidl", f"@qos({term})") for term in ("reliability",)}


def test_the_table_names_terms_of_the_quality() -> None:
    known = {"class"} | {name.removesuffix("_ns") for name in Qos.__slots__}
    assert {t.argument for t in not_yet.NOT_YET if t.annotation == "qos"} <= known
