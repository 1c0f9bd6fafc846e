"""What annotations, comments and includes come to mean in the model."""

import shutil
from pathlib import Path

import pytest
from gidl.compile import Compiled, compile_files
from gidl.model import (
    Attribute,
    Constant,
    EnumValue,
    Interface,
    Model,
    NamedType,
    Operation,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    Struct,
    Union,
)
from gidl.model.policy import Access, OnLoss, OnNew, QualityClass, Reliability, StreamDirection

HERE = Path(__file__).parent
IDL = HERE.parents[1] / "idl"
PREPROCESSOR = sorted((HERE / "preprocessor").glob("*.gidl"))


def test_a_char_is_one_of_256_characters() -> None:
    model = compile_files([str(HERE / "good/characters.gidl")]).model
    constants = {d.name: d.value for d in model.declarations() if isinstance(d, Constant)}
    assert constants == {
        "NUL": chr(0),
        "ZERO": chr(0),
        "LAST": chr(255),
        "OCTAL": chr(255),
        "QUOTE": "'",
    }
    letter = model.find("Letter")
    assert isinstance(letter, Union)
    assert [case.labels for case in letter.cases] == [(chr(0),), ("a", chr(128)), (chr(255),)]


@pytest.fixture(scope="module")
def machine() -> Interface:
    compiled = compile_files([str(HERE / "good/every_annotation.gidl")], [str(IDL)])
    return compiled.model.interface("lab::Machine")


def member(interface: Interface, name: str) -> Operation | Attribute:
    return next(m for m in interface.members if m.name == name)


def operation(interface: Interface, name: str) -> Operation:
    found = member(interface, name)
    assert isinstance(found, Operation)
    return found


def attribute(interface: Interface, name: str) -> Attribute:
    found = member(interface, name)
    assert isinstance(found, Attribute)
    return found


def compiled_text(folder: Path, text: str, name: str = "some.gidl") -> Compiled:
    (folder / name).write_text(text)
    return compile_files([str(folder / name)], [str(folder)])


def model_of(folder: Path, text: str) -> Model:
    compiled = compiled_text(folder, text)
    assert not compiled.findings
    return compiled.model


class TestAccess:
    def test_unwritten_operations_need_actor_and_presence(self, machine: Interface) -> None:
        found = operation(machine, "unannotated")
        assert (found.access, found.access_written) == (Access.ACTOR, False)
        assert found.needs_presence

    def test_sensor_operations_need_no_presence(self, machine: Interface) -> None:
        found = operation(machine, "measure")
        assert (found.access, found.needs_presence) == (Access.SENSOR, False)

    def test_presence_false_is_for_that_operation(self, machine: Interface) -> None:
        assert not operation(machine, "calibrate").needs_presence
        assert not attribute(machine, "volume").write_needs_presence

    def test_on_a_writable_attribute_it_speaks_of_setting(self, tmp_path: Path) -> None:
        interface = model_of(
            tmp_path,
            "interface I { @master attribute double a; @master readonly attribute double b; };",
        ).interface("I")
        first, second = attribute(interface, "a"), attribute(interface, "b")
        assert (first.read_access, first.write_access) == (Access.SENSOR, Access.MASTER)
        assert second.read_access is Access.MASTER

    def test_on_an_inward_stream_it_speaks_of_sending(self, machine: Interface) -> None:
        found = attribute(machine, "alter")
        assert found.write_access is Access.ACTOR
        assert not found.has_getter
        assert not found.has_setter

    def test_events_are_for_everybody_with_sensor_status(self, machine: Interface) -> None:
        found = operation(machine, "bumped")
        assert found.is_event
        assert found.access is Access.SENSOR


def test_how_a_call_runs(machine: Interface) -> None:
    move = operation(machine, "move")
    assert move.cancelable
    assert move.feedback == NamedType("lab::State")
    assert (move.on_new, move.on_loss) == (OnNew.BLEND, OnLoss.FINISH)
    assert operation(machine, "calibrate").parallel
    assert operation(machine, "mark").ordered
    assert operation(machine, "halt").safety


def test_quality_is_inherited_term_by_term(machine: Interface) -> None:
    assert machine.qos.quality_class is QualityClass.SOFT_REALTIME
    move = operation(machine, "move").qos
    assert (move.quality_class, move.latency_ns) == (QualityClass.SOFT_REALTIME, 5_000_000)
    assert (move.deadline_ns, move.start_by_ns) == (10_000_000_000, 500_000_000)
    assert move.reliability is Reliability.RELIABLE
    assert attribute(machine, "state").qos.media == ("shm", "lcm")


def test_quality_of_a_base_reaches_the_derived_interface() -> None:
    compiled = compile_files([str(HERE / "good/every_annotation.gidl")], [str(IDL)])
    small = compiled.model.interface("lab::Small")
    assert (small.qos.depth, small.qos.quality_class) == (2, QualityClass.SOFT_REALTIME)


def test_streams(machine: Interface) -> None:
    state, samples, alter = (attribute(machine, n).stream for n in ("state", "samples", "alter"))
    assert state is not None and samples is not None and alter is not None
    assert (state.direction, state.rate_hz) == (StreamDirection.OUT, 250.0)
    assert (samples.rate_hz, samples.is_open) == (1000.0, True)
    assert (alter.direction, alter.watchdog_ns) == (StreamDirection.IN, 48_000_000)


def test_annotation_comments_are_annotations() -> None:
    compiled = compile_files([str(HERE / "good/every_annotation.gidl")], [str(IDL)])
    small = compiled.model.interface("lab::Small")
    assert small.facts.version == "1.0"
    size = operation(small, "size")
    assert (size.result_unit, size.access) == ("m", Access.SENSOR)


def test_annotations_of_ones_own_are_kept() -> None:
    compiled = compile_files([str(HERE / "good/every_annotation.gidl")], [str(IDL)])
    (kept,) = compiled.model.struct("lab::State").facts.annotations
    assert kept.name == "colour"
    arguments = dict(kept.arguments)
    assert arguments["depth"] == 1
    kind = arguments["kind"]
    assert isinstance(kind, EnumValue)
    assert kind.literal == "GREEN"


class TestComments:
    def test_all_kinds_reach_their_declaration(self, tmp_path: Path) -> None:
        model = model_of(
            tmp_path,
            "/// About the\n"
            "/// struct.\n"
            "struct S {\n"
            "  /** Before. */\n"
            "  double a;  // behind\n"
            "  // of nobody\n"
            "  double b;  // first\n"
            "             // second\n"
            "  double c;\n"
            "  double d, e;  ///< both\n"
            "};\n",
        )
        struct = model.struct("S")
        assert struct.facts.doc == "About the\nstruct."
        docs = {m.name: m.facts.doc for m in struct.members}
        assert docs == {
            "a": "Before.\nbehind",
            "b": "first\nsecond",
            "c": "",
            "d": "both",
            "e": "both",
        }

    def test_stars_of_a_block_are_no_text(self, machine: Interface) -> None:
        assert machine.facts.doc == "A machine\nof many words."

    def test_parameters_and_events_have_theirs(self, machine: Interface) -> None:
        docs = [p.facts.doc for p in operation(machine, "move").parameters]
        assert docs == ["where to", "", "how often", "from where"]
        assert operation(machine, "bumped").facts.doc == "the server calls"

    def test_modules_have_theirs(self) -> None:
        compiled = compile_files([str(HERE / "good/every_annotation.gidl")], [str(IDL)])
        file = compiled.model.files[-1]
        assert [(m.name, m.facts.doc, m.facts.version) for m in file.modules] == [
            ("lab", "The laboratory.", "1.2")
        ]


class TestValues:
    def test_constants_are_computed(self) -> None:
        model = compile_files([str(HERE / "good/every_type.gidl")], [str(IDL)]).model
        values = {d.simple_name: d.value for d in model.declarations() if hasattr(d, "value")}
        assert values["N"] == 6 * 2 - (3 << 1) | 1
        assert values["HALF"] == 3.14159 / 2.0
        assert values["GREETING"] == "good morning\n"
        assert values["SMALLEST"] == -(2**63)
        assert values["FAVOURITE"] == EnumValue("lab::Colour", "GREEN", 5)
        both = values["BOTH"]
        assert isinstance(both, EnumValue)
        assert both.number == 3

    @pytest.mark.parametrize(
        ("expression", "value"),
        [
            ("-7 / 2", -3),
            ("-7 % 2", -1),
            ("7 / -2", -3),
            ("~0", -1),
            ("0x1F & 0xC", 12),
            ("2 + 3 * 4", 14),
            ("(2 + 3) * 4", 20),
            ("10 - 3 - 2", 5),
            ("1 << 3 >> 1", 4),
            ("017", 15),
            ("1 | 2 ^ 3 & 2", 1 | 2 ^ 3 & 2),
        ],
    )
    def test_operators_are_those_of_the_standard(
        self, tmp_path: Path, expression: str, value: int
    ) -> None:
        model = model_of(tmp_path, f"const long X = {expression};")
        assert getattr(model.find("X"), "value", None) == value

    @pytest.mark.parametrize(
        ("written", "value"),
        [
            ("1e-60", "0.0"),
            ("-1e-60", "-0.0"),
            ("7e-46", "0.0"),
            ("1e-45", "1e-45"),
            ("0.1", "0.1"),
        ],
    )
    def test_what_is_zero_as_a_float_is_zero(
        self, tmp_path: Path, written: str, value: str
    ) -> None:
        """C++ has no float that is written as 1e-60, and Python would send 0 for it."""
        model = model_of(
            tmp_path,
            f"const float F = {written}; const double D = {written};"
            f" struct S {{ @default({written}) float x; }};",
        )
        assert repr(getattr(model.find("F"), "value", None)) == value
        assert getattr(model.find("D"), "value", None) == float(written)
        assert repr(model.struct("S").members[0].default) == value

    def test_unit_and_range_of_a_typedef_reach_its_users(self, tmp_path: Path) -> None:
        struct = model_of(
            tmp_path,
            '@unit("m") @min(0) typedef double Length;'
            ' struct S { Length a; @unit("mm") Length b; };',
        ).struct("S")
        first, second = struct.members
        assert first.unit == "m"
        assert first.range is not None and first.range.minimum == 0.0
        assert second.unit == "mm"

    def test_types_are_what_was_written(self) -> None:
        model = compile_files([str(HERE / "good/every_type.gidl")], [str(IDL)]).model
        members = {m.name: m for m in model.struct("lab::All").members}
        assert members["lengths"].type == SequenceType(PrimitiveType(Primitive.DOUBLE), 9, "m")
        assert members["label"].default == "none"
        assert "fixed" in members
        assert [m.name for m in model.all_members(model.struct("lab::Derived"))][:3] == [
            "a",
            "b",
            "c",
        ]


class TestFiles:
    def test_without_search_folders_the_folder_idl_is_one(self, tmp_path: Path) -> None:
        folder = tmp_path / "idl" / "lab"
        folder.mkdir(parents=True)
        (folder / "a.gidl").write_text("module lab { struct A { double x; }; };")
        (folder / "b.gidl").write_text(
            '#include "lab/a.gidl"\nmodule lab { struct B { A one; }; };'
        )
        compiled = compile_files([str(folder / "b.gidl")])
        assert not compiled.findings
        assert [(f.path, f.asked_for) for f in compiled.model.files] == [
            ("lab/a.gidl", False),
            ("lab/b.gidl", True),
        ]

    def test_the_vocabulary_comes_with_the_package(self, tmp_path: Path) -> None:
        compiled = compiled_text(tmp_path, '#include "gecos/object.gidl"\n')
        assert not compiled.findings
        assert compiled.model.has("gecos::GecosObject")

    def test_a_guarded_file_included_twice_is_read_once(self, tmp_path: Path) -> None:
        (tmp_path / "a.gidl").write_text(
            "#ifndef A_H\n#define A_H\nstruct A { double x; };\n#endif\n"
        )
        (tmp_path / "b.gidl").write_text('#include "a.gidl"\n')
        model = model_of(tmp_path, '#include "a.gidl"\n#include "b.gidl"\nstruct C { A one; };')
        assert [d.name for d in model.declarations()] == ["A", "C"]

    @pytest.mark.parametrize("asked", [["a"], ["b"], ["a", "b"], ["b", "a"]], ids="-".join)
    def test_a_struct_is_completed_in_the_file_or_in_what_it_includes(
        self, tmp_path: Path, asked: list[str]
    ) -> None:
        """Otherwise `gidl gen a.gidl b.gidl` would write a header of `a` that lacks the struct."""
        (tmp_path / "a.gidl").write_text("module m { struct S; struct T { sequence<S> kids; }; };")
        (tmp_path / "b.gidl").write_text('#include "a.gidl"\nmodule m { struct S { T whole; }; };')
        compiled = compile_files([str(tmp_path / f"{name}.gidl") for name in asked])
        (found,) = compiled.findings
        assert (found.code, found.location and found.location.file) == ("G0113", "a.gidl")

    def test_a_struct_may_be_completed_in_an_included_file(self, tmp_path: Path) -> None:
        (tmp_path / "whole.gidl").write_text("module m { struct S { long x; }; };")
        model_of(
            tmp_path,
            '#include "whole.gidl"\nmodule m { struct S; struct T { sequence<S> kids; }; };',
        )

    def test_macros_of_an_included_file_are_known(self, tmp_path: Path) -> None:
        (tmp_path / "sizes.gidl").write_text("#pragma once\n#define AXES 6\n")
        struct = model_of(tmp_path, '#include "sizes.gidl"\nstruct S { double x[AXES]; };')
        assert isinstance(struct.find("S"), Struct)

    def test_macros_are_known_to_every_file_that_includes_them(self, tmp_path: Path) -> None:
        (tmp_path / "sizes.gidl").write_text("#pragma once\n#define AXES 6\n")
        for name in ("a", "b"):
            text = f'#include "sizes.gidl"\nstruct {name.upper()} {{ double x[AXES]; }};'
            (tmp_path / f"{name}.gidl").write_text(text)
        files = [str(tmp_path / "a.gidl"), str(tmp_path / "b.gidl")]
        assert not compile_files(files, [str(tmp_path)]).findings

    def test_undef_undefines_whatever_follows_the_name(self, tmp_path: Path) -> None:
        text = "#define A 1\n#undef A it is old\n#ifndef A\nconst long X = 1;\n#endif\n"
        assert [d.name for d in model_of(tmp_path, text).declarations()] == ["X"]

    def test_macros_are_expanded_in_annotation_comments(self, tmp_path: Path) -> None:
        """Also after code: as they are in the annotation that the comment stands for."""
        text = "#define LIMIT 5\nstruct S { @max(LIMIT) long a;\n long b; //@max(LIMIT)\n};\n"
        shown = model_of(tmp_path, "const long LIMIT_ = 100;\n" + text).find("S")
        assert isinstance(shown, Struct)
        assert [m.range for m in shown.members] == [Range(None, 5), Range(None, 5)]

    def test_skipped_annotation_comments_annotate_nothing(self, tmp_path: Path) -> None:
        text = "struct S {\n#if 0\n long b; //@max(4)\n#endif\n long c;\n};\n"
        assert not compiled_text(tmp_path, text).findings

    @pytest.mark.parametrize("file", PREPROCESSOR, ids=lambda p: p.stem)
    def test_windows_line_ends_change_nothing(self, tmp_path: Path, file: Path) -> None:
        shutil.copytree(file.parent / "parts", tmp_path / "parts")
        for place in tmp_path.rglob("*.gidl"):
            place.write_bytes(place.read_bytes().replace(b"\n", b"\r\n"))
        (tmp_path / file.name).write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
        found = compile_files([str(tmp_path / file.name)])
        assert not found.findings
        before = compile_files([str(file)]).model
        assert [d.name for d in found.model.declarations()] == [
            d.name for d in before.declarations()
        ]

    def test_comments_in_preprocessor_lines_are_spaces(self) -> None:
        file = HERE / "preprocessor/comments_and_continued_lines.gidl"
        declared = compile_files([str(file)]).model.declarations()
        constants = {d.name: d.value for d in declared if isinstance(d, Constant)}
        assert constants == {
            "VALUE": 1 + 2 + 3 + 7 + 5 + 6 + 9,
            "TEXT": 'a\tb // no comment, /* nor " this',
            "LINE": "\n",
            "RIGHT": "/",
        }

    def test_windows_line_ends_and_a_byte_order_mark_are_fine(self, tmp_path: Path) -> None:
        model_of(tmp_path, "\ufeff#pragma once\r\nstruct S {\r\n  double x;  // one\r\n};\r\n")
