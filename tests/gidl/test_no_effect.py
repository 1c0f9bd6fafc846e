"""`gidl check` warns about annotations that can have no effect where they are written."""

import re
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.compile import compile_files
from gidl.diagnostics.findings import Findings
from gidl.model.policy import Qos
from gidl.rules import no_effect

IDL = Path(__file__).parents[2] / "idl"

TEXT = """@final struct Image { @bulk sequence<octet> pixels; };
@qos(class=TIME_INDEPENDENT, latency="5ms", media="shm|lcm", deadline="1s")
interface Arm {
  @actor @idempotent @on_new("blend") @presence(FALSE)
  void move(@bulk in sequence<octet> path);
  @sensor @idempotent @qos(deadline="1s")
  long fine();
  @actor @on_new("queue") @qos(start_by="1s", liveliness=MANUAL, lifespan="1s", depth=2)
  void also();
  @sensor @stream(rate="10Hz") @open_stream
  @qos(depth=4, deadline="1s", start_by="1s") readonly attribute Image state;
  @actor @stream(dir="in", watchdog="8ms") @qos(deadline="1s", lifespan="1s", liveliness=MANUAL)
  attribute double speed;
  @event @qos(start_by="1s") oneway void touched();
};
@qos(on_degraded="fail") interface Belt {};
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.gidl").write_text(TEXT)
    return tmp_path


def terms(said: str) -> set[tuple[int, str]]:
    found = re.findall(r"^\S+?:(\d+):\d+: warning\[G0708\]: '(\S+)' of", said, re.MULTILINE)
    return {(int(line), term) for line, term in found}


def test_each_term_without_effect_is_named_where_it_is_written(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "a.gidl"]) == 0
    assert terms(capsys.readouterr().err) == {
        (2, "@qos(latency)"),
        (4, "@idempotent"),
        (5, "@bulk"),
        (8, "@qos(liveliness)"),
        (8, "@qos(lifespan)"),
        (8, "@qos(depth)"),
        (12, "@qos(deadline)"),
        (14, "@qos(start_by)"),
        (16, "@qos(on_degraded)"),
    }


SAID = {
    "@qos(latency)": "TIME_INDEPENDENT promises nothing about time\n"
    "write class=SOFT_REALTIME or class=HARD_REALTIME, or leave out 'latency'",
    "@idempotent": "a status ends with its session, so the call would be denied in a new session\n"
    "leave out '@idempotent', or write @sensor if the operation only reads",
    "@bulk": "the value is copied\n"
    "write the octets as the one '@bulk sequence<octet>' of a struct, and publish the struct as a "
    "@stream; elsewhere, leave out '@bulk'",
    "@qos(liveliness)": "only the writer of a stream must show that it is alive\n"
    "leave out 'liveliness': the session shows that the caller and the server are alive",
    "@qos(on_degraded)": "without a latency, the connection has no limit that it could exceed\n"
    "write 'latency' and a real-time class, or leave out 'on_degraded'",
    "@qos(lifespan)": "only the samples of a stream have a lifespan\n"
    "write 'start_by' or 'deadline' to limit the age of a call",
    "@qos(depth)": "only a stream keeps earlier samples\nleave out 'depth'",
    "@qos(start_by)": "only a call waits to be started\n"
    "write 'lifespan' to limit the age of a sample",
    "@qos(deadline)": "the time between two samples of a client is limited by 'watchdog' alone\n"
    "write 'watchdog' in @stream",
}


def test_each_finding_says_why_and_what_to_write_instead(here: Path) -> None:
    findings = Findings()
    no_effect.check(compile_files([str(here / "a.gidl")], [str(here)]).model, findings)
    said = {f.message.split("'")[1]: f for f in findings.found}
    told = {
        term: "\n".join([f.message.partition(" has no effect: ")[2], *f.help])
        for term, f in said.items()
    }
    assert told == SAID
    assert set(told) == {str(term) for term in no_effect.NO_EFFECT}, "each term has an example"


def test_the_latency_of_an_interface_binds_its_members_and_derived_interfaces_of_real_time(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "b.gidl").write_text(
        '@qos(latency="5ms") interface Arm {\n'
        "  @sensor @qos(class=SOFT_REALTIME) long prompt();\n"
        "};\n"
        '@qos(latency="5ms") interface Belt {\n'
        "  @sensor long slow();\n"
        "};\n"
        '@qos(latency="5ms") interface Base {};\n'
        "@qos(class=SOFT_REALTIME) interface Hand : Base { @sensor long angle(); };\n"
    )
    assert main(["check", "b.gidl"]) == 0
    assert terms(capsys.readouterr().err) == {(4, "@qos(latency)")}


def test_on_degraded_needs_a_latency_of_the_interface_a_member_or_a_base(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "b.gidl").write_text(
        '@qos(class=SOFT_REALTIME, on_degraded="fail") interface Arm { @sensor long angle(); };\n'
        '@qos(class=SOFT_REALTIME, latency="5ms") interface Base {};\n'
        '@qos(on_degraded="fail") interface Hand : Base { @sensor long angle(); };\n'
        '@qos(on_degraded="fail") interface Belt {\n'
        '  @sensor @qos(class=SOFT_REALTIME, latency="5ms") long speed();\n'
        "};\n"
    )
    assert main(["check", "b.gidl"]) == 0
    assert terms(capsys.readouterr().err) == {(1, "@qos(on_degraded)")}


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


def test_our_own_interfaces_write_nothing_without_effect() -> None:
    files = sorted(str(p) for p in IDL.rglob("*.gidl"))
    findings = Findings()
    no_effect.check(compile_files(files, [str(IDL)]).model, findings)
    assert not findings.found


def test_the_table_names_terms_of_the_quality() -> None:
    known = {"class"} | {name.removesuffix("_ns") for name in Qos.__slots__}
    assert {t.argument for t in no_effect.NO_EFFECT if t.annotation == "qos"} <= known
