"""Codes, hashes, sizes and fingerprints are what the documents say."""

import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from gidl.compile import compile_files
from gidl.model import Attribute, Model, Operation, Struct, Union
from gidl.targets.emit import render
from gidl.wire import function_codes, hashes, wire_layout
from gidl.wire.events import events_as_streams

IDL = Path(__file__).resolve().parents[2] / "idl"
GOOD = Path(__file__).parent / "good"


def model_of(folder: Path, text: str) -> Model:
    file = folder / "some.gidl"
    file.write_text(text)
    compiled = compile_files([str(file)], [str(folder)])
    assert not compiled.findings
    return compiled.model


def operation_hash(folder: Path, text: str) -> int:
    model = model_of(folder, text)
    (operation,) = model.interface("lab::I").operations
    return hashes.operation_hash(model, operation)


def test_codes_are_fnv1a_of_the_scoped_name() -> None:
    assert function_codes.fnv1a_32("") == 0x811C9DC5
    assert function_codes.fnv1a_32("a") == 0xE40C292C
    assert function_codes.fnv1a_32("foobar") == 0xBF9CF968


def test_getter_setter_stream_and_id(tmp_path: Path) -> None:
    model = model_of(
        tmp_path,
        'module lab { interface I { @stream(rate="1Hz") attribute double a;'
        ' @id(1000) attribute double b; @hash_as("old") void c(); }; };',
    )
    layout = wire_layout.build(model)
    fnv = function_codes.fnv1a_32
    assert layout.call("lab::I::a").code == layout.stream("lab::I::a").code == fnv("lab::I::a")
    assert layout.call("lab::I::a=").code == fnv("lab::I::a=")
    assert (layout.call("lab::I::b").code, layout.call("lab::I::b=").code) == (1000, 1001)
    assert layout.call("lab::I::c").code == fnv("lab::I::old")


def test_inherited_members_keep_the_code_of_the_declaring_interface(tmp_path: Path) -> None:
    model = model_of(
        tmp_path, "module lab { interface A { void go(); }; interface B : A { void stay(); }; };"
    )
    layout = wire_layout.build(model)
    names = [c.name for c in layout.all_calls(model, model.interface("lab::B"))]
    assert names == ["lab::A::go", "lab::B::stay"]


def test_the_reserved_operations_have_the_codes_of_the_document() -> None:
    compiled = compile_files([str(IDL / "gecos/object.gidl")], [str(IDL)])
    calls = wire_layout.build(compiled.model).interfaces["gecos::GecosObject"].calls
    codes = {c.name.rpartition("::")[2]: c.code for c in calls}
    assert codes["stop"] == 2
    assert sorted(codes.values()) == list(range(1, len(codes) + 1))


@pytest.mark.parametrize(
    "edited",
    [
        "void go(in S what, in long n, @optional in double more)",
        "void go(in S what, in long n, @default(1) in long more)",
        "@sensor void go(in S what, in long n)",
    ],
)
def test_compatible_edits_keep_the_operation_hash(tmp_path: Path, edited: str) -> None:
    before = (
        "module lab { @appendable struct S { double x; };"
        " interface I { void go(in S what, in long n); }; };"
    )
    after = (
        "module lab { @appendable struct S { double x; @optional string y; @default(1) long z; };"
        f" interface I {{ {edited}; }}; }};"
    )
    assert operation_hash(tmp_path, before) == operation_hash(tmp_path, after)


@pytest.mark.parametrize(
    "edited",
    [
        "void go(in S what, in long long n)",
        "void go(in S what, out long n)",
        "void go(in S what)",
        "void go(in S what, in long n, in long more)",
        "void go(in S what, in long m)",
        "double go(in S what, in long n)",
        "void go(in S what, in long n) raises (E)",
    ],
)
def test_incompatible_edits_change_the_operation_hash(tmp_path: Path, edited: str) -> None:
    text = (
        "module lab {{ @appendable struct S {{ double x; }}; exception E {{ string why; }};"
        " interface I {{ {}; }}; }};"
    )
    before = operation_hash(tmp_path, text.format("void go(in S what, in long n)"))
    assert before != operation_hash(tmp_path, text.format(edited))


def test_any_edit_of_what_travels_changes_the_interface_hash(tmp_path: Path) -> None:
    text = (
        "module lab {{ @appendable struct S {{ double x; {} }};"
        " interface I {{ void go(in S what); }}; }};"
    )
    one, other = (
        wire_layout.build(model_of(tmp_path, text.format(extra))).interfaces["lab::I"].hash
        for extra in ("", "@optional double y;")
    )
    assert one != other


def test_sizes(tmp_path: Path) -> None:
    model = model_of(
        tmp_path,
        "module lab { enum E { A }; struct P { double x; float y; octet z[3]; E kind; };"
        " @appendable struct G { P inner; };"
        " struct S { G grows; string t; sequence<P> q; @optional P o; P two[2]; }; };",
    )
    structs = wire_layout.build(model).structs
    assert structs["lab::P"].fixed_size == structs["lab::P"].min_size == 8 + 4 + 3 + 4
    assert structs["lab::G"].fixed_size == 19
    assert structs["lab::S"].fixed_size is None
    assert structs["lab::S"].min_size == 4 + 5 + 4 + 1 + 38


def test_count_names_get_underscores_until_they_are_free(tmp_path: Path) -> None:
    model = model_of(
        tmp_path,
        "module lab { struct S { long x_n; sequence<double> x; long x_n_; long struct_; }; };",
    )
    members = wire_layout.build(model).structs["lab::S"].lcm.members
    assert [m.name for m in members] == ["x_n", "x_n__", "x", "x_n_", "struct_"]


def lcm_gen() -> Path:
    return Path(sysconfig.get_path("scripts")) / "lcm-gen"


@pytest.mark.parametrize(
    "file", sorted(GOOD.glob("*.gidl")) + sorted(IDL.glob("*/*.gidl")), ids=str
)
def test_fingerprints_are_those_of_lcm_gen(file: Path, tmp_path: Path) -> None:
    compiled = compile_files([str(file)], [str(IDL), str(GOOD)])
    everything = [str(IDL / f.path) for f in compiled.model.files if (IDL / f.path).exists()]
    compiled = compile_files([*everything, str(file)], [str(IDL), str(GOOD)])
    model = events_as_streams(compiled.model)
    layout = wire_layout.build(model)
    for path, text in render(model, layout, ["lcm"]).items():
        place = tmp_path / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)
    sources = sorted(str(p) for p in tmp_path.rglob("*.lcm"))
    out = tmp_path / "python"
    subprocess.run([lcm_gen(), "-p", "--ppath", out, *sources], check=True, capture_output=True)
    ours = {
        s.lcm.name: s.fingerprint & 0xFFFFFFFFFFFFFFFF
        for s in (*layout.structs.values(), *layout.unions.values())
        if "." in s.lcm.name  # lcm-gen's Python of nested types without a package does not run
    }
    script = (
        "import sys\nsys.path.insert(0, sys.argv[1])\nimport importlib\nfor n in sys.argv[2:]:\n"
        + (
            "    m, _, c = n.rpartition('.')\n"
            "    t = getattr(importlib.import_module(m or c), c)\n"
            "    print(n, t._get_packed_fingerprint().hex())\n"
        )
    )
    run = subprocess.run(
        [sys.executable, "-c", script, str(out), *ours],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    theirs = {n: int(h, 16) for n, h in re.findall(r"^(\S+) (\w+)$", run.stdout, re.MULTILINE)}
    assert theirs == ours


def test_every_member_of_the_corpus_has_a_layout() -> None:
    files = [str(p) for p in sorted(GOOD.glob("*.gidl"))]
    model = events_as_streams(compile_files(files, [str(IDL), str(GOOD)]).model)
    layout = wire_layout.build(model)
    for declaration in model.declarations():
        if isinstance(declaration, Struct):
            assert len(layout.structs[declaration.name].fields) == len(
                model.all_members(declaration)
            )
        elif isinstance(declaration, Union):
            assert len(layout.unions[declaration.name].arms) == len(declaration.cases)
    for interface in model.interfaces():
        calls = {c.name for c in layout.interfaces[interface.name].calls}
        for member in interface.members:
            if isinstance(member, Operation):
                assert member.scoped_name in calls
            elif isinstance(member, Attribute):
                assert (member.scoped_name in calls) == member.has_getter
                assert (f"{member.scoped_name}=" in calls) == member.has_setter


FROZEN = """module frozen {
  enum Gear { @default_literal NEUTRAL, @value(7) DRIVE };
  @bit_bound(12) bitmask Rights { READ, @position(9) WRITE };
  bitset Head { bitfield<3> low; bitfield<1> last; };
  typedef double Row[3];
  @final struct Point { @unit("m") double x; @range(min=0, max=5) float y; };
  @appendable struct Goal { Point at; @optional string<9> name; @default(1) long tries; };
  union Reading switch (Gear) { case NEUTRAL: Row cells; default: sequence<octet, 8> raw; };
  exception Refused { string why; };
  interface Base { @sensor void look(); };
  interface Cart : Base {
    @actor Goal go(in Goal to, inout Reading seen, out map<short, Gear> gears,
                   @default(2) in long times) raises (Refused);
    @sensor @stream(rate="9Hz") readonly attribute Point place;
    @id(4711) attribute Rights allowed;
    @event oneway void bumped(in Head top, in Base by);
  };
};
"""


def test_the_sign_of_a_bit_field_is_in_the_hash(tmp_path: Path) -> None:
    told = set()
    for kind in ("", ", octet", ", int8"):
        text = f"bitset B {{ bitfield<3{kind}> a; }}; interface I {{ void put(in B bits); }};"
        model = model_of(tmp_path, text)
        told.add(hashes.interface_hash(model, model.interface("I")))
    assert len(told) == 2


IDENTITIES = {
    "fingerprint of Point": "85a6ae9c505f57c6",
    "fingerprint of Goal": "e616c5296ba4a4b4",
    "fingerprint of Refused": "55b842c4e0ba6fe4",
    "fingerprint of Reading": "d1a253db6c0f0d29",
    "fingerprint of Cart::bumped": "2d7621001617c962",
    "code of Base::look": "5b4367a1",
    "code of Cart::go": "4ba088ab",
    "code of Cart::place": "9dd1e3dc",
    "code of Cart::allowed": "00001267",
    "code of Cart::allowed=": "00001268",
    "code of Cart::bumped": "dcb62bdc",
    "hash of Cart": "7b80b503a0b2e59c",
    "hash of Cart::go": "d244b9555d2b888b",
    "hash of Cart::place": "eaa4a79b4a0c8a03",
    "hash of Cart::allowed": "e1cf624fdac8db34",
    "hash of Cart::bumped": "f85ef16197804726",
}


def test_what_identifies_things_on_the_wire_never_changes(tmp_path: Path) -> None:
    """Programs that were built with an earlier gidl have these numbers in them."""
    model = events_as_streams(model_of(tmp_path, FROZEN))
    layout = wire_layout.build(model)
    cart = model.interface("frozen::Cart")
    types = {**layout.structs, **layout.unions}
    told = {f"fingerprint of {n}": f"{t.fingerprint % 2**64:016x}" for n, t in types.items()}
    told |= {f"code of {c.name}": f"{c.code:08x}" for c in layout.all_calls(model, cart)}
    streams = layout.interfaces[cart.name].streams
    told |= {f"code of {s.name}": f"{s.code:08x}" for s in streams}
    told["hash of frozen::Cart"] = f"{hashes.interface_hash(model, cart):016x}"
    for member in cart.members:
        if isinstance(member, Attribute):
            number = hashes.attribute_hash(model, member)
        else:
            number = hashes.operation_hash(model, member)
        told[f"hash of {member.scoped_name}"] = f"{number:016x}"
    assert {name.replace("frozen::", ""): number for name, number in told.items()} == IDENTITIES
