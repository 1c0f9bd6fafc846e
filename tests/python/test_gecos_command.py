from __future__ import annotations

import contextlib
import json
import os
import sys
from typing import Any

import gecos
import pytest
from command_output import valid
from gecos.cli import main
from lamp import Lamp, PlainLamp


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["gecos", *words])
    return main()


def test_ls_lists_what_is_online(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    server.add("SPARE", PlainLamp())
    assert run(monkeypatch, "ls") == 0
    heads, first, second = capsys.readouterr().out.splitlines()
    assert heads.split()[:2] == ["name", "type"]
    assert first.split()[:2] == ["LAMP", "test::Lamp"]
    assert "simulated" in first
    assert second.split()[:2] == ["SPARE", "test::Lamp"]
    assert "hardware" in second
    assert "lcm, shm" in first


def test_ls_names_only_media_that_lead_to_other_programs(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    server.add("HIDDEN", PlainLamp(), media=["inproc"])
    assert run(monkeypatch, "ls") == 0
    _, hidden, _ = capsys.readouterr().out.splitlines()
    assert "only the server's own process" in hidden
    assert "inproc" not in hidden


def test_a_misspelt_name_is_told_the_right_one(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "describe", "lmap") == 4
    said = "gecos: lmap: NO_SERVER: no such object is online; did you mean LAMP?\n"
    assert capsys.readouterr().err == said


def test_ls_of_an_empty_laboratory_says_so(
    lab: gecos.Lab, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "ls") == 0
    assert capsys.readouterr().out == "no object is online\n"


def test_without_a_broker_it_says_what_was_tried(
    place: object, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "ls") == 4
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("gecos: BROKER: NO_SERVER: ")


@pytest.mark.parametrize("variable", ["GECOS_BROKER", "GECOS_LAB_FILE", "GECOS_RUNTIME_DIR"])
def test_a_place_that_is_no_text_is_refused_by_name(
    place: object,
    variable: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv(variable, os.fsdecode(b"/tmp/\xff"))
    assert run(monkeypatch, "ls") == 1
    said = f"gecos: {variable} is b'/tmp/\\xff', which is not UTF-8; set it to valid UTF-8\n"
    assert capsys.readouterr().err == said


def test_describe_shows_state_of_any_object(
    held: Lamp, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "describe", "LAMP") == 0
    out = capsys.readouterr().out
    assert out.startswith("LAMP\n  type            test::Lamp 1.0\n  device          simulated\n")
    assert f"  pid             {os.getpid()}\n" in out
    assert out.count(str(os.getpid())) == 1, "the caller's own pid tells nothing of the object"


def test_describe_says_that_an_object_serves_no_model(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "describe", "LAMP") == 0
    _, _, said = capsys.readouterr().out.rpartition("\n\n")
    assert said.startswith("LAMP serves no model; generate the code of its server again")


def test_holders_shows_who_moves_it(
    held: Lamp, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "holders", "LAMP") == 0
    _, holder = capsys.readouterr().out.splitlines()
    assert holder.split()[0] == "actor"
    assert str(os.getpid()) in holder


def test_stats_shows_the_calls_of_an_object_and_of_its_clients(
    held: Lamp, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(3):
        held.label().result()
    held.dim(0.25).result()
    assert run(monkeypatch, "stats", "LAMP") == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["label", "3", "3", "0"] in [row[:4] for row in rows]
    assert ["dim", "1", "1", "0"] in [row[:4] for row in rows]
    assert any(str(os.getpid()) in row for row in rows)
    assert run(monkeypatch, "stats") == 0
    (summary,) = [row.split() for row in capsys.readouterr().out.splitlines() if "LAMP" in row]
    assert summary[-5:-2] == ["4", "4", "0"]

    for words in (["stats", "LAMP"], ["stats"]):
        assert run(monkeypatch, *words, "--json") == 0
        said = capsys.readouterr().out
        assert valid(said, "stats")
        (told,) = json.loads(said)
        counted = {each["operation"]: each for each in told["operations"]}
        assert counted["label"]["ended"] == {"DONE": 3}
        assert counted["label"]["worst"] > 0


@pytest.mark.parametrize("words", [("holders", "LAMP", "--watch"), ("watch", "LAMP")])
@pytest.mark.parametrize("form", ["--json", None])
def test_each_change_of_the_holders_is_shown(
    words: tuple[str, ...],
    form: str | None,
    lamp: Lamp,
    server: gecos.Server,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with gecos.actor(lamp):
        seen = changing_meanwhile(lamp, monkeypatch)
        assert run(monkeypatch, *words, *[form] * bool(form)) == 130
    out = capsys.readouterr().out
    assert seen.count("taken over") == 1
    if not form:
        changed = [line for line in out.splitlines() if f"pid {os.getpid()}) has" in line]
        assert [line.rpartition(") ")[2] for line in changed] == [
            "has taken over",
            "has given back",
        ]
        return
    told = [json.loads(line) for line in out.splitlines()[:-1]]  # the last says how it ended
    if words[0] == "holders":
        assert [holder["taken_over"] for (holder,) in told] == [False, False]
    else:
        assert [[change["what"] for change in each["changes"]] for each in told] == [
            [],
            ["TAKEN_OVER", "GIVEN_BACK"],
        ]
        assert all(valid(line, "watch") for line in out.splitlines()[:-1])


@pytest.mark.parametrize("form", ["--json", None])
def test_a_count_of_a_watch_of_the_holders_is_of_changes(
    form: str | None,
    lamp: Lamp,
    server: gecos.Server,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with gecos.actor(lamp):
        changing_meanwhile(lamp, monkeypatch)
        assert run(monkeypatch, "watch", "LAMP", "--count", "1", *[form] * bool(form)) == 0
    out = capsys.readouterr().out
    assert ("TAKEN_OVER" if form else "has taken over") in out


def changing_meanwhile(lamp: Lamp, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Lets `lamp` take over and give back between the first and second question of the command
    about the roster, and presses Ctrl-C before the third."""
    ask = gecos.roster
    seen: list[str] = []

    def asked(robot: Any, after: int = 0, timeout: float | None = 0.0) -> Any:
        seen.append("asked")
        if len(seen) == 2:
            gecos.take_over(lamp).result()
            gecos.give_back(lamp).result()
            seen.append("taken over")
        if len(seen) > 3:
            raise KeyboardInterrupt
        return ask(robot, after, timeout)

    monkeypatch.setattr(gecos, "roster", asked)
    return seen


@pytest.mark.parametrize("words", [("holders", "LAMP", "--watch"), ("watch", "LAMP")])
@pytest.mark.parametrize("replaced", [True, False])
def test_a_watch_of_the_holders_says_what_it_missed(
    words: tuple[str, ...],
    replaced: bool,
    lamp: Lamp,
    server: gecos.Server,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    server.add("NEXT", PlainLamp(), simulated=True)
    ask = gecos.roster
    robots: list[Any] = []

    def asked(robot: Any, after: int = 0, timeout: float | None = 0.0) -> Any:
        robots.append(robot)
        if len(robots) == 3:
            raise KeyboardInterrupt
        if len(robots) == 2 and replaced:
            return ask(following, after, timeout)
        if len(robots) == 2:
            for _ in range(130):
                gecos.take_over(lamp).result()
                gecos.give_back(lamp).result()
        return ask(robot, after, timeout)

    monkeypatch.setattr(gecos, "roster", asked)
    with gecos.Lab() as second, gecos.actor(lamp):
        following = second.create(Lamp, "NEXT")
        assert run(monkeypatch, *words) == 130
    warned = capsys.readouterr().err.splitlines()[0]
    if replaced:
        assert warned == (
            "gecos: LAMP: another server serves this object now; earlier changes of its holders "
            "may have been missed"
        )
    else:  # the object keeps 256 of the 260
        assert warned == "gecos: LAMP: 4 earlier changes of the holders of this object were missed"


def test_holders_of_a_free_object_says_so(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "holders", "LAMP") == 0
    assert capsys.readouterr().out == "LAMP: nobody holds actor or master status\n"


def test_stop_stops_whoever_moves_it(
    held: Lamp,
    servant: PlainLamp,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    assert run(monkeypatch, "stop", "LAMP") == 0
    assert capsys.readouterr().out == "LAMP: stopped\n"
    burning.wait()
    assert burning.progress().detail is gecos.Detail.STOPPED


def test_break_takes_the_status_away_and_says_who_and_why(
    held: Lamp,
    servant: PlainLamp,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    assert run(monkeypatch, "break", "LAMP", "--why", "nobody is here") == 0
    assert capsys.readouterr().out == "LAMP: nobody holds its status any more\n"
    with pytest.raises(gecos.CommandFailed, match=r"an administrator, .* nobody is here$") as lost:
        burning.result()
    assert lost.value.detail is gecos.Detail.LEASE_LOST
    assert gecos.holders(held).result() == []


def test_break_of_a_free_object_says_that_nobody_held_it(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "break", "LAMP", "--why", "to be sure") == 0
    assert capsys.readouterr().out == "LAMP: nobody held its status before\n"


def test_break_takes_master_status_away_too(
    lamp: Lamp, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with contextlib.suppress(gecos.ConnectionFailed), gecos.master(lamp):
        assert run(monkeypatch, "break", "LAMP", "--why", "nobody is here") == 0
    assert capsys.readouterr().out == "LAMP: nobody holds its status any more\n"


def test_the_broker_can_be_described_and_stopped_as_an_object(
    lab: gecos.Lab, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for verb, told in {
        "describe": "gecos::Broker",
        "holders": "BROKER: nobody holds actor or master status\n",
        "stats": "BROKER: served for ",
        "stop": "BROKER: stopped\n",
    }.items():
        assert run(monkeypatch, verb, "BROKER") == 0
        assert told in capsys.readouterr().out
    assert run(monkeypatch, "stop", "--all") == 0
    assert capsys.readouterr().out == "nothing was stopped\n"
    assert run(monkeypatch, "break", "BROKER", "--why", "to be sure") == 0
    assert capsys.readouterr().out == "BROKER: nobody held its status before\n"


def test_members_of_the_broker_are_called_and_watched(
    lab: gecos.Lab, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for words, told in {
        ("wait", "BROKER", "--timeout", "1"): "BROKER: online\n",
        ("call", "BROKER", "list"): "[]\n",
        ("watch", "BROKER", "--timeout", "0.1"): "BROKER: nobody holds",
    }.items():
        run(monkeypatch, *words)
        assert told in capsys.readouterr().out


def test_an_unknown_name_names_those_that_are_online(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "describe", "ROBOT") == 4
    assert capsys.readouterr().err == (
        "gecos: ROBOT: NO_SERVER: no such object is online; start the object's server, "
        "or choose a name that the broker knows: LAMP\n"
    )


@pytest.mark.parametrize("words", [("explode",), ("stop",), ("ls", "--nonsense")])
def test_wrong_usage_exits_with_2(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, *words) == 2
    assert "Usage" in capsys.readouterr().err


def test_a_misspelt_command_is_told_the_right_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "list") == 2
    assert "No such command 'list'; did you mean ls?" in capsys.readouterr().err
    assert run(monkeypatch, "explode") == 2
    assert "did you mean" not in capsys.readouterr().err


def test_help_exits_with_0(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "--help") == 0
    assert "holders" in capsys.readouterr().out
