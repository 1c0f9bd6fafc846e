"""`gecos plot` without an arm that moves: what it computes, reads, draws and refuses."""

from __future__ import annotations

import builtins
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_output import Run, valid
from gecos.cli.exit_codes import UsageFailure
from gecos.cli.plot.limits import read_limits
from gecos.cli.plot.motion import (
    MEASURED_OVER,
    Course,
    magnitude,
    of_joints,
    of_tool,
    slope,
    times,
    trimmed,
)
from gecos.cli.plot.recorder import _joined
from gecos.cli.plot.recording import Numbers, Recording, read_csv, write_csv
from gecos.stream import Sample
from matplotlib.testing.compare import compare_images

ARMS = Path(__file__).resolve().parents[2] / "devices" / "arms"
CYCLE = 0.004


def recording(
    joints: Numbers | None = None, tool: Numbers | None = None, jitter: float = 0.0, **other: Any
) -> Recording:
    """What an arm sends whose control loop wakes up `jitter` too early or too late."""
    rows = len(tool) if joints is None and tool is not None else len(joints)  # type: ignore[arg-type]
    number = np.arange(rows, dtype=np.float64)
    late = np.random.default_rng(1).uniform(-jitter, jitter, rows)
    late[0] = 0
    facts: dict[str, Any] = {
        "name": "ARM",
        "interface": "robcl::SixAxis",
        "cycle": CYCLE,
        "number": number,
        "stamp": number * CYCLE + late,
        "tool": np.zeros((rows, 3)) if tool is None else tool,
        "joints": joints,
        "commanded": joints,
        "lost": {"tool": 0},
        "missed_cycles": 0,
    }
    return Recording(**(facts | other))


def trapezium(peak: float, acceleration: float, cruise: float, stands: float = 0.5) -> Numbers:
    """Positions of a joint that stands, accelerates to `peak`, cruises, brakes and stands."""
    ramp = peak / acceleration
    t = np.arange(0, 2 * stands + 2 * ramp + cruise, CYCLE) - stands
    up = np.clip(t, 0, ramp)
    down = np.clip(t - ramp - cruise, 0, ramp)
    return np.asarray(
        acceleration * up**2 / 2
        + peak * np.clip(t - ramp, 0, cruise)
        + peak * down
        - acceleration * down**2 / 2
    )[:, None]


def test_speed_and_acceleration_of_a_trapezium_are_those_of_its_formula() -> None:
    motion = of_joints(recording(trapezium(peak=2.0, acceleration=8.0, cruise=0.4)))
    assert motion is not None
    assert motion.speed.value.max() == pytest.approx(2.0)
    assert motion.acceleration.value.max() == pytest.approx(8.0)
    assert motion.acceleration.value.min() == pytest.approx(-8.0)
    cruising = np.abs(motion.acceleration.time - (0.5 + 0.25 + 0.2)) < 0.15
    assert np.abs(motion.acceleration.value[cruising]).max() < 1e-6


def test_slopes_of_a_sine_are_at_the_middle_of_their_intervals() -> None:
    t = np.arange(0, 2, CYCLE)
    speed = slope(Course(t, np.sin(t)[:, None]))
    assert np.abs(speed.value[:, 0] - np.cos(speed.time)).max() < 1e-5
    over = slope(Course(t, np.sin(t)[:, None]), MEASURED_OVER)
    assert np.abs(over.value[:, 0] - np.cos(over.time)).max() < 1e-4


def test_a_loop_that_wakes_up_late_shows_no_acceleration_that_is_not_there() -> None:
    late = recording(trapezium(peak=2.0, acceleration=8.0, cruise=0.4), jitter=2e-4)
    motion = of_joints(late)
    assert motion is not None
    assert np.abs(motion.acceleration.value).max() == pytest.approx(8.0)


def test_without_a_cycle_or_with_another_rate_the_stamps_count() -> None:
    joints = trapezium(1.0, 8.0, 0.1)
    unknown = recording(joints, cycle=None)
    assert times(unknown) is unknown.stamp
    slower = recording(joints, cycle=0.001)  # of four cycles, one is sent
    assert times(slower) is slower.stamp


def test_a_lost_row_changes_no_speed() -> None:
    whole = recording(trapezium(2.0, 8.0, 0.4))
    kept = np.delete(np.arange(len(whole)), [100, 101, 180])
    lossy = recording(
        trapezium(2.0, 8.0, 0.4)[kept],
        number=whole.number[kept],
        stamp=whole.stamp[kept],
        tool=whole.tool[kept],
    )
    motion = of_joints(lossy)
    assert motion is not None
    assert motion.speed.value.max() == pytest.approx(2.0)
    assert np.abs(motion.acceleration.value).max() == pytest.approx(8.0)


def test_the_tool_of_a_circle_has_its_speed_and_its_centripetal_acceleration() -> None:
    angle = np.arange(0, 6, CYCLE) * 2.0  # rad/s
    circle = 0.1 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    circle[50] = np.nan  # a sample that was lost
    tool = of_tool(recording(tool=circle))
    assert np.allclose(magnitude(tool.speed).value, 0.2, rtol=2e-3)
    assert np.allclose(magnitude(tool.acceleration).value, 0.4, rtol=2e-2)


def test_a_recording_is_cut_to_its_motion() -> None:
    cut = trimmed(recording(trapezium(2.0, 8.0, 0.4, stands=1.0)))
    assert times(cut)[0] == 0
    assert times(cut)[-1] == pytest.approx(0.1 + 0.25 + 0.4 + 0.25 + 0.1, abs=4 * CYCLE)
    first = trimmed(recording(trapezium(2.0, 8.0, 0.4, stands=1.0)), seconds=0.3)
    assert times(first)[-1] == pytest.approx(0.1 + 0.3, abs=2 * CYCLE)


def test_a_motion_that_ends_where_it_began_is_kept() -> None:
    there = trapezium(2.0, 8.0, 0.0)
    cut = trimmed(recording(np.concatenate([there, there[::-1]])))
    assert times(cut)[-1] == pytest.approx(0.2 + 2 * 0.5 + 2 * 0.5, abs=4 * CYCLE)


def test_a_table_gives_the_recording_again(tmp_path: Path) -> None:
    joints = np.hstack([trapezium(2.0, 8.0, 0.4)] * 6)
    tool = np.column_stack([joints[:, 0], joints[:, 0], joints[:, 0]])
    tool[7] = np.nan
    before = recording(joints, tool, jitter=1e-4, lost={"tool": 1, "joints": 0}, missed_cycles=2)
    write_csv(before, tmp_path / "motion.csv")
    after = read_csv(tmp_path / "motion.csv")
    assert (after.name, after.interface, after.cycle) == ("ARM", "robcl::SixAxis", CYCLE)
    assert (after.lost, after.missed_cycles) == ({"tool": 1, "joints": 0}, 2)
    for member in ("number", "stamp", "tool", "joints", "commanded"):
        read, written = getattr(after, member), getattr(before, member)
        assert np.allclose(read, written, atol=1e-6, equal_nan=True), member


GOOD = """\
# gecos plot 1
# {"name": "ARM", "interface": "robcl::M", "cycle_s": 0.004, "lost": {}, "missed_cycles": 0}
number,stamp_s,tool_x_m,tool_y_m,tool_z_m
0,0,0.1,0,0
1,0.004,0.2,0,0
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("# gecos plot 1", "time,x", "motion.csv:1: the line is not '# gecos plot 1'"),
        ('"cycle_s"', '"cycle"', "motion.csv:2: the line does not describe a recording"),
        ("tool_y_m,", "", "motion.csv:3: the columns are not number, stamp_s, tool_x_m"),
        ("0,0,0.1,0,0", "0,0,0.1,0", "motion.csv:4: 4 values, not 5"),
        ("1,0.004,0.2", "1,0.004,here", "motion.csv:5: tool_x_m is 'here', which is no finite"),
        ("1,0.004,0.2", "1,0.004,nan", "motion.csv:5: tool_x_m is 'nan', which is no finite"),
        ("1,0.004,0.2", "1,,0.2", "motion.csv:5: stamp_s is '', which is no finite number"),
        ("1,0.004", "0,0.004", "motion.csv:5: number and stamp_s do not increase"),
    ],
)
def test_another_table_is_refused_with_its_line(
    old: str, new: str, said: str, tmp_path: Path, run: Run
) -> None:
    assert old in GOOD
    (tmp_path / "motion.csv").write_text(GOOD.replace(old, new))
    code, _, err = run("plot", "--from", str(tmp_path / "motion.csv"))
    assert code == 2
    assert said in err
    assert "gecos plot NAME --csv FILE" in err


def test_a_table_that_ends_early_is_refused(tmp_path: Path, run: Run) -> None:
    (tmp_path / "motion.csv").write_text("\n".join(GOOD.splitlines()[:2]))
    assert (
        "motion.csv:2: the file ends before" in run("plot", "--from", f"{tmp_path}/motion.csv")[2]
    )
    (tmp_path / "motion.csv").write_text(GOOD)
    code, _, err = run("plot", "--from", f"{tmp_path}/motion.csv")
    assert (code, "a motion has at least 3 samples" in err) == (2, True)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    joints = np.hstack([share * trapezium(2.0, 8.0, 0.4) for share in (1, 0.5, -0.5, 0, 1, 2)])
    write_csv(recording(joints, 0.1 * joints[:, :3]), tmp_path / "motion.csv")
    return tmp_path / "motion.csv"


def test_the_same_recording_gives_the_same_picture(table: Path, run: Run) -> None:
    pictures = []
    for name in ("a.svg", "b.svg"):
        code, out, err = run("plot", "--from", str(table), "-o", str(table.parent / name))
        assert code == 0, err
        assert out.startswith(f"{table.parent / name}: ARM, ")
        pictures.append((table.parent / name).read_text())
    assert pictures[0] == pictures[1]
    assert "<dc:date>" not in pictures[0]
    for label in ("commanded joints, °", "joint 6", "joint speed, °/s", "time, s", "top view"):
        assert label in pictures[0], label


def test_a_png_and_the_default_name_and_json(table: Path, run: Run) -> None:
    assert run("plot", "--from", str(table), "-o", str(table.parent / "a.png"))[0] == 0
    assert run("plot", "--from", str(table), "-o", str(table.parent / "b.png"))[0] == 0
    assert compare_images(str(table.parent / "a.png"), str(table.parent / "b.png"), 0) is None
    code, out, err = run("plot", "--from", str(table), "--json")
    assert code == 0, err
    assert valid(out, "plot")
    assert json.loads(out)["picture"] == str(table.with_suffix(".svg"))
    assert table.with_suffix(".svg").exists()


def test_with_limits_speeds_are_shares_of_them(table: Path, run: Run) -> None:
    code, _, err = run("plot", "--from", str(table), "--limits", str(ARMS / "rx90.toml"))
    assert code == 0, err
    drawn = table.with_suffix(".svg").read_text()
    assert "joint speed, % of its limit" in drawn
    assert "joint acceleration, % of its limit" in drawn
    assert run("plot", "--from", str(table), "--limits", str(ARMS / "rx90.urdf"))[0] == 0
    drawn = table.with_suffix(".svg").read_text()
    assert "joint acceleration, °/s²" in drawn, "a URDF file has no accelerations"


def test_an_arm_without_joint_streams_is_drawn_by_its_tool(table: Path, run: Run) -> None:
    moved = trapezium(0.2, 1.0, 0.4)
    tool = np.hstack([moved, 0 * moved, -moved])
    nothing = recording(tool=tool, joints=None, commanded=None, interface="robcl::Manipulator")
    write_csv(nothing, table)
    assert run("plot", "--from", str(table))[0] == 0
    drawn = table.with_suffix(".svg").read_text()
    assert "tool in the world, mm" in drawn
    assert "joint" not in drawn


def test_a_picture_is_drawn_although_all_samples_of_the_tool_were_lost(
    table: Path, run: Run
) -> None:
    before = read_csv(table)
    write_csv(recording(before.joints, before.tool * np.nan), table)
    code, _, err = run("plot", "--from", str(table))
    assert code == 0, err


def test_the_limits_of_the_rx90_are_read() -> None:
    limits = read_limits(ARMS / "rx90.toml")
    assert limits.joints == tuple(f"joint{i}" for i in range(1, 7))
    assert np.allclose(np.degrees(limits.upper), [160, 137.5, 142.5, 270, 120, 270])
    assert np.allclose(np.degrees(limits.speed), [236, 200, 286, 401, 320, 580])
    assert limits.acceleration is not None
    assert np.allclose(limits.acceleration, limits.speed / 0.25)
    assert (limits.tool_speed, limits.tool_acceleration) == (1, 3)


@pytest.mark.parametrize("arm", ["rx90", "rx90l", "puma560", "iiwa14"])
def test_the_limits_of_every_arm_of_the_tree_are_read(arm: str) -> None:
    limits = read_limits(ARMS / f"{arm}.toml")
    assert len(limits.joints) == (7 if arm == "iiwa14" else 6)
    assert (limits.lower < limits.upper).all()
    assert np.array_equal(read_limits(ARMS / f"{arm}.urdf").speed, limits.speed)


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("arm.yaml", "", "in a file ARM.toml or ARM.urdf; name such a file"),
        ("arm.toml", "= 1", "arm.toml: this is no TOML"),
        ("arm.toml", "name = 'A'", "arm.toml: the key urdf is missing or no text"),
        ("arm.urdf", "<robot>", "arm.urdf: this is no XML"),
        ("arm.urdf", "<robot/>", "arm.urdf: there is no revolute joint"),
        (
            "arm.urdf",
            '<robot><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>'
            "</robot>",
            "arm.urdf: joint 'j' has no number 'lower' in <limit>",
        ),
    ],
)
def test_a_file_without_limits_is_refused(
    file: str, text: str, said: str, table: Path, run: Run
) -> None:
    path = table.parent / file
    path.write_text(text)
    code, _, err = run("plot", "--from", str(table), "--limits", str(path))
    assert code == 2
    assert said in err


def test_the_limits_of_another_arm_are_refused(table: Path, run: Run) -> None:
    code, _, err = run("plot", "--from", str(table), "--limits", str(ARMS / "iiwa14.toml"))
    assert code == 2
    assert "ARM has 6 joints, but --limits names the file of an arm with 7" in err


def test_seconds_to_full_speed_must_fit_the_joints(tmp_path: Path) -> None:
    text = (ARMS / "rx90.toml").read_text().replace('"rx90.urdf"', f'"{ARMS}/rx90.urdf"')
    for bad in ("[0.25, 0.25]", "0", '"soon"'):
        path = tmp_path / "arm.toml"
        path.write_text(text.replace("full_speed = 0.25", f"full_speed = {bad}"))
        with pytest.raises(UsageFailure, match="each of the 6 joints"):
            read_limits(path)


def test_joints_of_two_chains_need_a_toml_file(tmp_path: Path) -> None:
    joint = (
        '<joint name="{0}" type="revolute"><parent link="foot"/><child link="{0}"/>'
        '<limit lower="-1" upper="1" velocity="1"/></joint>'
    )
    path = tmp_path / "two.urdf"
    path.write_text(f"<robot>{joint.format('left')}{joint.format('right')}</robot>")
    with pytest.raises(UsageFailure, match=r"more than one chain; name the ARM\.toml"):
        read_limits(path)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ((), 2, "give either the NAME of an arm, or --from FILE"),
        (("ARM", "--from", "a.csv"), 2, "give either the NAME of an arm, or --from FILE"),
        (("--from", "a.csv", "--csv", "b.csv"), 2, "leave out --csv and --seconds"),
        (("ARM", "-o", "a.pdf"), 2, "'a.pdf' does not end in .svg or .png"),
        (("ARM", "-o", "/nowhere/a.svg"), 1, "there is no folder /nowhere; create it"),
        (("ARM", "--csv", "/proc/a.csv"), 1, "/proc is write-protected; name another file"),
        (("--from", "/nowhere/a.csv", "-o", "/tmp/a.svg"), 1, "No such file or directory"),
    ],
)
def test_what_cannot_be_done_is_refused_before_a_recording(
    words: tuple[str, ...], code: int, said: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.access", lambda path, mode: str(path) != "/proc")  # root may all
    ended, _, err = run("plot", *words)
    assert ended == code
    assert said in err


def test_without_matplotlib_it_says_how_to_install_it(
    table: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def missing(name: str, *others: Any) -> Any:
        if name == "matplotlib":
            raise ImportError("No module named 'matplotlib'", name="matplotlib")
        return real(name, *others)

    monkeypatch.setattr(builtins, "__import__", missing)
    code, _, err = run("plot", "--from", str(table))
    assert code == 1
    assert "pip install matplotlib" in err
    assert len(err.splitlines()) == 1


def test_samples_of_one_cycle_stand_in_one_row() -> None:
    def sample(value: Any, number: int, lost: int = 0) -> Sample[Any]:
        return Sample(value, 70 + number, lost, 1000.0 + number * CYCLE, 0.0)

    at = {"position": {"x": 0.1, "y": 0.2, "z": 0.3}, "orientation": {}}
    joints = [sample({"position": [number] * 6}, number) for number in range(3)]
    tool = [sample(at, 0), sample(at, 2, lost=1)]
    streams = {"tool": tool, "joints": joints, "commanded_joints": joints[:1] + joints[2:]}
    joined = _joined("ARM", "robcl::SixAxis", CYCLE, 0, streams, 6)
    assert joined.number.tolist() == [0, 2]
    assert joined.tool.tolist() == [[0.1, 0.2, 0.3]] * 2
    assert joined.joints is not None and joined.joints[:, 0].tolist() == [0, 2]
    assert joined.lost == {"tool": 1, "joints": 0, "commanded_joints": 0}
    streams |= {"commanded_joints": joints}
    without = _joined("ARM", "robcl::SixAxis", CYCLE, 0, streams, 6)
    assert np.isnan(without.tool[1]).all(), "its sample was lost"
    nothing = _joined("ARM", "robcl::Manipulator", CYCLE, 0, {"tool": []}, 0)
    assert len(nothing) == 0
