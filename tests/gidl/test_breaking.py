# ruff: noqa: E501 (a table)
"""`gidl breaking`: edits and their verdicts, the texts of one whole report, and the command."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from gidl.breaking import category_of, compare
from gidl.cli.main import main
from gidl.compile import Compiled, compile_files

HERE = Path(__file__).parent

BASE = """
module lab {
  enum Gear { @default_literal NEUTRAL, DRIVE, REVERSE };
  enum Kind { TALL, SMALL };
  @bit_bound(8) bitmask Rights { READ, WRITE };
  bitset Head { bitfield<3> kind; bitfield<1> last; };
  typedef double Row[3];
  const long LIMIT = 5;
  @final struct Point { @unit("m") double x; @unit("m") double y; };
  @appendable struct Goal { Point at; @optional @unit("m/s") double speed; @default(1) long tries; };
  @final union Reading switch (Kind) { case TALL: @secret string high; case SMALL: long low; };
  @appendable exception Refused { string why; };
  exception Broken { string why; };
  @version("1.0") interface Machine { @sensor void look(); };
  @version("1.0") @qos(class=SOFT_REALTIME, latency="5ms")
  interface Cart : Machine {
    @actor @idempotent @cancelable(feedback="lab::Goal") @on_new("queue")
    void go(in Goal to, @default(2) in long times) raises (Refused);
    @actor @qos(reliability=RELIABLE, deadline="10s", media="shm|lcm") void turn(in Gear chosen);
    @sensor @safety void halt();
    @sensor @unit("m") double measure(in Row cells, in Reading value, in Rights bits, in Head top);
    @master @presence(FALSE) void calibrate();
    void log_in(@secret in string password);
    @sensor @stream(rate="100Hz") @qos(depth=4) readonly attribute Point place;
    @actor @stream(dir="in", rate="250Hz", watchdog="48ms") attribute Point alter;
    @actor @range(min=0, max=1) attribute double volume;
    @event oneway void bumped();
  };
};
"""

# (name, what is replaced, by what, verdict as codes: none for what is compatible)
EDITS = [
    ("nothing", "", "", ""),
    ("a comment", "  typedef double Row", "  /** A row. */\n  typedef double Row", ""),
    ("a new operation", "@sensor @safety void halt();",
     "@sensor @safety void halt(); @sensor void more();", ""),
    ("a new type", "module lab {", "module lab { @final struct More { long x; };", ""),
    ("operations reordered", "void look(); }", "void look(); @sensor void more(); }", ""),
    ("an optional parameter appended", "in long times)",
     "in long times, @optional in long pause)", ""),
    ("a defaulted parameter appended", "void turn(in Gear chosen)",
     "void turn(in Gear chosen, @default(1) in long speed)", ""),
    ("an optional member appended", "long tries; }", "long tries; @optional string who; }", ""),
    ("a defaulted member appended", "string why; };\n  exception",
     "string why; @default(0) long code; };\n  exception", ""),
    ("a literal appended to an enum with a default", "REVERSE }", "REVERSE, PARK }", ""),
    ("a base added", "interface Cart : Machine",
     "interface Other { @sensor void more(); }; interface Cart : Machine, Other", ""),
    ("a quality made stricter", 'latency="5ms"', 'latency="2ms"', ""),
    ("a reliability that is the default", "@qos(reliability=RELIABLE, ", "@qos(", ""),
    ("a reliability of samples that is the default", "@qos(depth=4)", "@qos(depth=4, reliability=BEST_EFFORT)", ""),
    ("a rate raised", 'rate="100Hz"', 'rate="200Hz"', ""),
    ("an exception renamed, its hash kept", "exception Broken", '@hash_as("Broken") exception Cracked', "G1101"),
    ("a member renamed, its hash kept", "long tries;", '@hash_as("tries") long attempts;', "G1101"),
    ("an operation renamed, its hash kept", "@sensor @safety void halt",
     '@hash_as("halt") @sensor @safety void cease', "G1101"),

    ("an operation gone", "@sensor @safety void halt();", "", "G1001"),
    ("an operation renamed", "void halt()", "void cease()", "G1001"),
    ("an attribute gone", "@actor @range(min=0, max=1) attribute double volume;", "", "G1001"),
    ("a base gone", "interface Cart : Machine", "interface Cart", "G1001"),
    ("an interface gone", '@version("1.0") interface Machine { @sensor void look(); };',
     "interface Other {};", "BASE"),
    ("a parameter required at the end", "in long times)", "in long times, in long pause)",
     "G1002 G1003"),
    ("a parameter inserted", "void turn(in Gear chosen", "void turn(@default(1) in long x, in Gear chosen",
     "G1002"),
    ("a parameter gone", "in Row cells, ", "", "G1002"),
    ("a parameter at the end gone", ", @default(2) in long times", "", "G1101"),
    ("a parameter renamed", "in Gear chosen", "in Gear which", "G1002"),
    ("parameters in another order", "in Row cells, in Reading value", "in Reading value, in Row cells",
     "G1002"),
    ("a parameter of another type", "in long times", "in double times", "G1002"),
    ("a parameter of another direction", "in Gear chosen", "inout Gear chosen", "G1002"),
    ("a default gone", "@default(2) in long times", "in long times", "G1002"),
    ("another default", "@default(2) in long times", "@default(3) in long times", "G1102"),
    ("another result", '@unit("m") double measure', '@unit("m") float measure', "G1002"),
    ("another unit of a result", '@unit("m") double measure', '@unit("mm") double measure', "G1006"),
    ("a member appended to a final struct", "double y; };", "double y; @optional double z; };",
     "G1002"),
    ("a member required at the end", "long tries; };", "long tries; long more; };", "G1002 G1002 G1003"),
    ("a member gone", '@unit("m") double x; ', "", "G1002"),
    ("a member at the end gone", " @default(1) long tries;", "", "G1101"),
    ("a member at the end replaced", "@default(1) long tries;", "@default(1) long attempts;", "G1002"),
    ("a member of another type", "@default(1) long tries;", "@default(1) short tries;", "G1002"),
    ("optional to defaulted", "@default(1) long tries;", "@optional long tries;", "G1002"),
    ("another unit", '@unit("m") double y', '@unit("mm") double y', "G1006"),
    ("a range", '@unit("m") double y', '@unit("m") @min(0) double y', "G1006"),
    ("another range", "max=1) attribute", "max=2) attribute", "G1006"),
    ("final to appendable", "@final struct Point", "@appendable struct Point", "G1002"),
    ("a literal gone", ", REVERSE", "", "G1101"),
    ("a literal renamed", "REVERSE", "BACK", "G1004"),
    ("literals renumbered", "DRIVE, REVERSE", "REVERSE, DRIVE", "G1004 G1004"),
    ("another default literal", "@default_literal NEUTRAL, DRIVE", "NEUTRAL, @default_literal DRIVE",
     "G1004"),
    ("no default literal", "@default_literal NEUTRAL", "NEUTRAL", "G1004"),
    ("a literal of an enum without a default", "TALL, SMALL", "TALL, SMALL, WIDE", "G1004"),
    ("a literal gone without a default", "SMALL };",
     "OTHER };", "UNION"),
    ("a flag", "READ, WRITE", "READ, WRITE, ALL", "G1004"),
    ("a bit field", "bitfield<1> last;", "bitfield<1> last; bitfield<1> first;", "G1004"),
    ("the sign of a bit field", "bitfield<3> kind", "bitfield<3, int8> kind", "G1004"),
    ("a bit field of octet that was of uint8", "bitfield<3> kind", "bitfield<3, octet> kind", ""),
    ("another type of a bit field", "bitfield<3> kind", "bitfield<3, uint16> kind", "G1102"),
    ("a case", "case SMALL: long low;", "case SMALL: double low;", "G1004"),
    ("a typedef", "typedef double Row[3]", "typedef double Row[4]", "G1002 G1102"),
    ("another exception", "raises (Refused)", "raises (Refused, Broken)", "G1007"),
    ("an answer to oneway", "@sensor void look()", "@sensor oneway void look()", "G1002"),
    ("a function code", "@master @presence(FALSE)", "@id(4711) @master @presence(FALSE)", "G1005"),
    ("a stream no more", '@stream(rate="100Hz") @qos(depth=4)', "@qos(depth=4)", "G1002"),
    ("readonly to writable", "readonly attribute Point place", "attribute Point place", "G1002"),
    ("an operation to an attribute", "@sensor void look()", "@sensor readonly attribute long look",
     "G1002"),
    ("other feedback", 'feedback="lab::Goal"', 'feedback="lab::Point"', "G1002"),

    ("an optional out parameter appended", "in Head top)", "in Head top, @optional out double spread)",
     "G1102"),
    ("an optional out parameter of what returned nothing", "void look()", "void look(@optional out long seen)",
     "G1102"),
    ("a constant", "LIMIT = 5", "LIMIT = 6", "G1102"),
    ("a constant of another type", "const long LIMIT", "const short LIMIT", "G1102"),
    ("a constant gone", "const long LIMIT = 5;", "", "G1101"),
    ("an unused type gone", "exception Broken { string why; };", "", "G1101"),

    ("a lower class", "class=SOFT_REALTIME", "class=TIME_INDEPENDENT", "G1201"),
    ("a longer latency", 'latency="5ms"', 'latency="6ms"', "G1201"),
    ("another end of a slow session", 'latency="5ms"', 'latency="5ms", on_degraded="fail"', "G1201"),
    ("the default end of a slow session", 'latency="5ms"', 'latency="5ms", on_degraded="event"', ""),
    ("less reliability", "reliability=RELIABLE", "reliability=BEST_EFFORT", "G1201"),
    ("less reliability of all calls", '@qos(class=SOFT_REALTIME, latency="5ms")',
     '@qos(class=SOFT_REALTIME, latency="5ms", reliability=BEST_EFFORT)', "G1201"),
    ("a stream that becomes reliable", "@qos(depth=4)", "@qos(depth=4, reliability=RELIABLE)", "G1201"),
    ("an inward stream that becomes reliable", 'watchdog="48ms")', 'watchdog="48ms") @qos(reliability=RELIABLE)',
     "G1201"),
    ("an event that becomes reliable", "@event oneway", "@event @qos(reliability=RELIABLE) oneway", "G1201"),
    ("a longer deadline", 'deadline="10s"', 'deadline="11s"', "G1201"),
    ("no deadline", 'deadline="10s", ', "", "G1201"),
    ("a medium less", 'media="shm|lcm"', 'media="shm"', "G1201"),
    ("a lower rate", 'rate="100Hz"', 'rate="50Hz"', "G1201"),
    ("fewer samples", "depth=4", "depth=2", "G1201"),
    ("a longer watchdog", 'watchdog="48ms"', 'watchdog="1s"', "G1201"),
    ("no watchdog", ', watchdog="48ms"', "", "G1201"),
    ("not idempotent", "@idempotent ", "", "G1201"),
    ("not cancelable", '@cancelable(feedback="lab::Goal") ', "", "G1002 G1201"),
    ("another answer to a running command", '@on_new("queue")', '@on_new("preempt")', "G1201"),
    ("beside others", "@actor @qos(reliability", "@actor @parallel @qos(reliability", "G1201"),

    ("actor to sensor", "@actor @qos(reliability", "@sensor @qos(reliability", "G1301"),
    ("sensor to actor", "@sensor @safety void halt", "@actor @safety void halt", "G1301"),
    ("master to actor", "@master @presence(FALSE)", "@actor @presence(FALSE)", "G1301"),
    ("a setter for all", "@actor @range", "@sensor @range", "G1301"),
    ("presence needed no more", "@actor @qos(reliability", "@actor @presence(FALSE) @qos(reliability",
     "G1301"),
    ("presence needed", "@presence(FALSE) void", "void", "G1301"),
    ("safety", "@sensor void look()", "@sensor @safety void look()", "G1301"),
    ("no safety", "@safety void halt", "void halt", "G1301"),
    ("is not stopped any more when the holder of the lease is lost", '@on_new("queue")', '@on_new("queue") @on_loss("finish")',
     "G1301"),
    ("an open stream", '@stream(rate="100Hz") @qos(depth=4)', '@stream(rate="100Hz") @open_stream @qos(class=TIME_INDEPENDENT, depth=4)', "G1201 G1301"),
    ("no secret", "@secret in string", "in string", "G1302"),
    ("no secret in a union", "@secret string high", "string high", "G1302"),
    ("no secret in a union that changes", "@secret string high", "string<5> high", "G1004 G1302"),
]  # fmt: skip

SPECIAL = {
    "BASE": {"G1001", "G1301"},
    "UNION": {"G1004"},
}


def compiled(folder: Path, name: str, text: str) -> Compiled:
    place = folder / name / "lab.gidl"
    place.parent.mkdir(exist_ok=True)
    place.write_text(text)
    result = compile_files([str(place)], [str(place.parent)])
    assert not result.has_errors, [f.message for f in result.findings]
    return result


@pytest.mark.parametrize(("name", "before", "after", "codes"), EDITS, ids=[e[0] for e in EDITS])
def test_verdict(name: str, before: str, after: str, codes: str, tmp_path: Path) -> None:
    assert before in BASE
    edited = BASE.replace(before, after) if before else BASE
    if name == "an interface gone":
        edited = edited.replace("interface Cart : Machine", "interface Cart")
    if name == "a literal gone without a default":
        edited = edited.replace("case SMALL", "case OTHER")
    assert name == "nothing" or edited != BASE
    old, new = compiled(tmp_path, "old", BASE), compiled(tmp_path, "new", edited)
    found = compare(old.model, new.model)
    said = [(f.code, f.message) for f in found]
    if codes in SPECIAL:
        assert {f.code for f in found} >= {min(SPECIAL[codes])}, said
    else:
        assert sorted(f.code for f in found) == sorted(codes.split()), said
    for finding in found:
        assert finding.message.startswith(f"{category_of(finding.code)}: ")
        assert len(finding.help) == 2, "why, and what to do instead"
        assert finding.location is not None


STREAM = "@final struct Point { double x; };\ninterface Cart { @sensor @stream @qos(TERMS) "
STREAM += "readonly attribute Point place; };"


@pytest.mark.parametrize(
    ("was", "is_now", "said"),
    [
        (
            "reliability=RELIABLE",
            "depth=4",
            "QOS: 'Cart::place' promised reliability RELIABLE and now promises BEST_EFFORT: its "
            "samples may be lost over lcm",
        ),
        (
            "depth=4",
            "depth=4, reliability=RELIABLE",
            "QOS: 'Cart::place' is RELIABLE now: clients cannot subscribe to it over lcm any more "
            "(QOS_UNAVAILABLE)",
        ),
        ('media="shm"', 'media="shm", reliability=RELIABLE', None),
        ('media="lcm"', 'media="shm|lcm", reliability=RELIABLE', "QOS: 'Cart::place' is RELIABLE"),
        ("reliability=BEST_EFFORT", "depth=4", None),
        (
            "depth=4",
            'depth=4, media="shm"',
            "QOS: 'Cart::place' cannot be reached over lcm any more",
        ),
        ("depth=4", 'depth=4, media="inproc|shm|lcm"', None),
        ('media="inproc|shm"', 'media="shm"', None),
        ('media="shm"', 'media="inproc"', "QOS: 'Cart::place' cannot be reached over shm any more"),
    ],
)
def test_what_a_stream_promises_of_its_samples(
    was: str, is_now: str, said: str | None, tmp_path: Path
) -> None:
    old = compiled(tmp_path, "old", STREAM.replace("TERMS", was))
    new = compiled(tmp_path, "new", STREAM.replace("TERMS", is_now))
    found = [f.message for f in compare(old.model, new.model)]
    assert len(found) == (0 if said is None else 1), found
    assert said is None or found[0].startswith(said)


def test_a_member_more_in_the_struct_that_a_call_returns_breaks_nothing(tmp_path: Path) -> None:
    text = "interface I {{ @sensor double width(out long count{}); }};"
    old = compiled(tmp_path, "old", text.format(""))
    new = compiled(tmp_path, "new", text.format(", @optional out double spread"))
    assert compare(old.model, new.model) == []


DERIVED = "struct P { double x; }; struct Q : P { double y; };"


@pytest.mark.parametrize(
    ("was", "is_now", "said"),
    [
        (DERIVED, "struct P { double x; }; struct Q { double x; double y; };",
         ["SOURCE: 'Q' had the base 'P' and now has no base"]),
        ("struct P { double x; }; struct Q { double x; double y; };", DERIVED,
         ["SOURCE: 'Q' had no base and now has the base 'P'"]),
        (DERIVED, "struct P { double x; }; struct R { double x; }; struct Q : R { double y; };",
         ["SOURCE: 'Q' had the base 'P' and now has the base 'R'"]),
        (DERIVED, '@hash_as("P") struct R { double x; }; struct Q : R { double y; };',
         ["SOURCE: 'R' was named 'P' before"]),
        (DERIVED, "struct P { double x; }; struct Q { double y; };",
         ["WIRE: member 'x' of 'Q' is gone"]),
    ],
    ids=["gone", "new", "another", "renamed, its hash kept", "gone with its members"],
)  # fmt: skip
def test_the_base_of_a_struct_stays_also_if_its_members_do(
    was: str, is_now: str, said: list[str], tmp_path: Path
) -> None:
    old, new = compiled(tmp_path, "old", was), compiled(tmp_path, "new", is_now)
    assert [f.message for f in compare(old.model, new.model)] == said


def test_findings_are_sorted_by_category(tmp_path: Path) -> None:
    edited = BASE.replace("LIMIT = 5", "LIMIT = 6").replace("@actor @qos(rel", "@sensor @qos(rel")
    edited = edited.replace('rate="100Hz"', 'rate="50Hz"').replace("double y;", "float y;")
    old, new = compiled(tmp_path, "old", BASE), compiled(tmp_path, "new", edited)
    categories = [category_of(f.code) for f in compare(old.model, new.model)]
    assert categories == ["WIRE", "SOURCE", "QOS", "SECURITY"]


TYPES = """
@range(min=0, max=1) typedef long Small;
@range(min=0, max=2) typedef long Large;
@range(min=0, max=255) typedef octet Any_octet;
@unit("m") typedef double Metres;
@unit("mm") typedef double Millimetres;
typedef sequence<Small> Smalls;
"""
# (what the type of a slot was, what it is, the change that is told)
INSIDE = [
    ("sequence<Small>", "sequence<long>",
     "the range of the elements of {} was 0 to 1 and is now unlimited"),
    ("sequence<long>", "sequence<Small>",
     "the range of the elements of {} was unlimited and is now 0 to 1"),
    ("Smalls", "sequence<Large>",
     "the range of the elements of {} was 0 to 1 and is now 0 to 2"),
    ("sequence<Smalls>", "sequence<sequence<long>>",
     "the range of the elements of {} was 0 to 1 and is now unlimited"),
    ("map<string, Small>", "map<string, Large>",
     "the range of the values of {} was 0 to 1 and is now 0 to 2"),
    ("map<Small, string>", "map<long, string>",
     "the range of the keys of {} was 0 to 1 and is now unlimited"),
    ("map<string, Smalls>", "map<string, sequence<long>>",
     "the range of the elements of the values of {} was 0 to 1 and is now unlimited"),
    ("Smalls", "sequence<Small>", ""),
    ("sequence<Any_octet>", "sequence<octet>", ""),
    ("sequence<Metres>", "sequence<Millimetres>", "{} was in 'm' and is now in 'mm'"),
]  # fmt: skip
SLOTS = """
struct S { TYPE x; };
union U switch (boolean) { case TRUE: TYPE x; };
typedef TYPE T;
@version("1.0") interface I {
  @sensor TYPE get();
  @sensor void put(in TYPE x);
  readonly attribute TYPE x;
};
"""
NAMES = [
    "member 'x' of 'S'", "member 'x' of 'U'", "type 'T'",
    "the result of 'I::get'", "parameter 'x' of 'I::put'", "attribute 'I::x'",
]  # fmt: skip


@pytest.mark.parametrize(("before", "after", "told"), INSIDE)
def test_units_and_ranges_inside_a_type_are_compared(
    before: str, after: str, told: str, tmp_path: Path
) -> None:
    old = compiled(tmp_path, "old", TYPES + SLOTS.replace("TYPE", before))
    new = compiled(tmp_path, "new", TYPES + SLOTS.replace("TYPE", after))
    found = sorted((f.code, f.message) for f in compare(old.model, new.model))
    expected = [("G1006", f"WIRE: {told.format(name)}") for name in NAMES if told]
    assert found == sorted(expected)


EXACT = [
    ("union U switch (E) { case P: long x; case Q: string y; };", True),
    ("union U switch (E) { case P: long x; default: string y; };", True),
    ("typedef E T; union U switch (T) { case P: long x; };", True),
    ("@final struct S { map<E, long> m; };", True),
    ("typedef E T; typedef map<long, sequence<map<T, long>>> M;", True),
    ("interface I { @sensor void put(in sequence<map<E, long>> m); };", True),
    ("interface I { @sensor readonly attribute map<E, long> m; };", True),
    ("@final struct S { map<long, E> m; };", False),
    ("interface I { @sensor E get(); };", False),
]


@pytest.mark.parametrize(("use", "is_broken"), EXACT)
def test_tags_and_keys_take_no_literal_for_the_default(
    use: str, is_broken: bool, tmp_path: Path
) -> None:
    small = compiled(tmp_path, "old", "enum E { @default_literal P, Q };\n" + use)
    large = compiled(tmp_path, "new", "enum E { @default_literal P, Q, R };\n" + use)
    grown = [(f.code, f.message) for f in compare(small.model, large.model)]
    assert grown == ([("G1004", "WIRE: 'R' of 'E' is new")] if is_broken else [])
    (shrunk,) = compare(large.model, small.model)
    assert shrunk.code == ("G1004" if is_broken else "G1101")


def test_a_new_map_with_an_old_enum_as_key_breaks_nothing(tmp_path: Path) -> None:
    old = compiled(tmp_path, "old", "enum E { @default_literal P, Q };\n")
    new = compiled(
        tmp_path, "new", "enum E { @default_literal P, Q, R };\nstruct S { map<E, long> m; };\n"
    )
    assert compare(old.model, new.model) == []


def test_a_range_that_every_value_is_in_is_none(tmp_path: Path) -> None:
    old = compiled(
        tmp_path, "old", "struct S { @range(min=0, max=255) octet x; @max(5) octet y; };"
    )
    new = compiled(tmp_path, "new", "struct S { octet x; @range(min=0, max=5) octet y; };")
    assert compare(old.model, new.model) == []


def test_what_the_comparison_overlooks_the_hashes_find(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    edited = BASE.replace("in Gear chosen", "in Gear which")
    old, new = compiled(tmp_path, "old", BASE), compiled(tmp_path, "new", edited)
    monkeypatch.setattr("gidl.breaking.slots.compare", lambda *_: None)
    assert [f.code for f in compare(old.model, new.model)] == ["G1008"]


def test_a_type_in_another_file_is_found_and_its_move_told(tmp_path: Path) -> None:
    old = compiled(tmp_path, "old", "@final struct S { long x; };\n")
    place = tmp_path / "new" / "other.gidl"
    place.parent.mkdir()
    place.write_text("@final struct S { long x; };\n")
    new = compile_files([str(place)], [str(place.parent)])
    assert [f.code for f in compare(old.model, new.model)] == ["G1102"]


class TestCommand:
    @pytest.fixture(autouse=True)
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        monkeypatch.chdir(tmp_path)
        for folder, text in (("was", BASE), ("idl", BASE)):
            (tmp_path / folder).mkdir()
            (tmp_path / folder / "lab.gidl").write_text(text)
        return tmp_path

    def test_the_same_interfaces_break_nothing(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["breaking", "--against", "was"]) == 0
        assert capsys.readouterr() == ("", "")

    def test_every_finding_is_told_as_in_the_golden(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        """Every edit that has one code by itself, one report after the other."""
        reports = []
        for name, before, after, codes in EDITS:
            if codes and codes not in SPECIAL:
                (here / "idl" / "lab.gidl").write_text(BASE.replace(before, after))
                assert main(["breaking", "--against", "was"]) == 100
                reports.append(f"==== {name}\n{capsys.readouterr().err}")
        said = "".join(reports)
        golden = HERE / "breaking" / "edits.txt"
        if os.environ.get("GIDL_WRITE_GOLDENS"):
            golden.write_text(said, encoding="utf-8")
        assert said == golden.read_text(encoding="utf-8")
        assert re.search(r"^gidl: 1 WIRE, 0 SOURCE, 0 QOS, 0 SECURITY$", said, re.MULTILINE)

    def test_against_a_commit(self, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
        shutil.rmtree(here / "was")
        self.commit()
        (here / "idl" / "lab.gidl").write_text(BASE.replace("@sensor @safety void halt();", ""))
        assert main(["breaking", "--against", "git#ref=HEAD"]) == 100
        said = capsys.readouterr().err
        assert "WIRE: operation 'lab::Cart::halt' is gone" in said
        assert re.search(
            r"^HEAD:idl/lab.gidl:\d+:\d+: note: the old declaration is here$", said, re.MULTILINE
        )
        assert main(["breaking", "--against", "git#ref=HEAD,subdir=was"]) == 1
        assert main(["breaking", "--against", "git#ref=nowhere"]) == 1
        assert "git has no idl/ in 'nowhere'" in capsys.readouterr().err

    def commit(self) -> None:
        for command in (
            ["init", "--quiet"],
            ["add", "."],
            ["-c", "user.name=n", "-c", "user.email=e", "commit", "--quiet", "-m", "first"],
        ):
            subprocess.run(["git", *command], check=True)

    @pytest.mark.parametrize("against", ["was", "git#ref=HEAD"])
    def test_what_is_not_named_is_not_gone(
        self, here: Path, against: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for folder in ("was", "idl"):
            (here / folder / "base.gidl").write_text("@final struct B { long x; };\n")
            (here / folder / "one.gidl").write_text(
                '#include "base.gidl"\n@final struct One { B inner; };\ninterface Old {};\n'
            )
        self.commit()
        assert main(["breaking", "--against", against, "idl/one.gidl"]) == 0
        assert capsys.readouterr() == ("", "")
        (here / "idl" / "base.gidl").write_text("@final struct B { double x; };\n")
        (here / "idl" / "one.gidl").write_text(
            '#include "base.gidl"\n@final struct One { B inner; };\n'
        )
        assert main(["breaking", "--against", against, "idl/one.gidl"]) == 100
        said = capsys.readouterr().err
        assert "interface 'Old' is gone" in said
        assert "member 'x' of 'B' was int32" in said, "what the file includes is compared too"
        assert "lab::" not in said

    def test_what_is_not_included_any_more_is_not_gone(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for folder in ("was", "idl"):
            (here / folder / "one.gidl").write_text(
                '#include "lab.gidl"\n@final struct One { long x; };\n'
            )
        (here / "idl" / "one.gidl").write_text("@final struct One { long x; };\n")
        assert main(["breaking", "--against", "was", "idl/one.gidl"]) == 0

    def test_a_new_file_breaks_nothing(self, here: Path) -> None:
        self.commit()
        (here / "idl" / "new.gidl").write_text("@final struct New { long x; };\n")
        assert main(["breaking", "--against", "git#ref=HEAD", "idl/new.gidl"]) == 0

    def test_a_commit_is_read_from_wherever_one_stands(
        self,
        here: Path,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        (here / "sub").mkdir()
        self.commit()
        edited = BASE.replace("@sensor @safety void halt();", "")
        (here / "idl" / "lab.gidl").write_text(edited)
        monkeypatch.chdir(here / "sub")
        for words in (["../idl/lab.gidl"], ["-I", "../idl", "../idl/lab.gidl"]):
            assert main(["breaking", "--against", "git#ref=HEAD", *words]) == 100
            assert "HEAD:../idl/lab.gidl:" in capsys.readouterr().err
        assert main(["breaking", "--against", "git#ref=HEAD", "-"]) == 2

    @pytest.mark.parametrize("against", ["nowhere", "git#", "git#tag=x", "git#ref=--help", "empty"])
    def test_what_cannot_be_compared_with_is_said(
        self, here: Path, against: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "empty").mkdir()
        assert main(["breaking", "--against", against]) == 1
        assert capsys.readouterr().err.startswith("gidl: --against: ")

    @pytest.mark.parametrize("against", ["nowhere", "git#ref=nowhere"])
    def test_what_cannot_be_compared_with_is_a_finding_for_other_tools(
        self, here: Path, against: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        command = ["breaking", "--against", against, "--error-format"]
        assert main([*command, "json"]) == 1
        (found,) = json.loads(capsys.readouterr().out)
        assert (found["code"], found["file"]) == ("G0025", against)
        assert main([*command, "sarif"]) == 1
        (result,) = json.loads(capsys.readouterr().out)["runs"][0]["results"]
        assert result["ruleId"] == "G0025"

    def test_wrong_interfaces_before_are_told_apart(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "was" / "lab.gidl").write_text("struct S { Missing x; };\n")
        assert main(["breaking", "--against", "was"]) == 1
        assert "--against: was has errors in its interfaces" in capsys.readouterr().err
