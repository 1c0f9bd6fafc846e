"""Open streams: stock LCM tools record and decode what a server publishes."""

from __future__ import annotations

import json
import os
import pwd
import secrets
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import gecos
import pytest
from barograph import Barograph, Reading
from lcm import LCM, EventLog
from processes import PATIENCE_S, Laboratory, Program, until

TREE = Path(__file__).resolve().parents[2]
HERE = Path(__file__).parent / "open"
FIRST, TIMES = 100, 10


def of_wheel(path: str) -> Path:
    return Path(str(distribution("lcm").locate_file(path)))


@pytest.fixture(scope="module")
def lcm_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The `.lcm` file that gidl makes of the interface."""
    out = tmp_path_factory.mktemp("gidl")
    words = ["--lang", "lcm", "-I", TREE / "idl", "--out", out]
    made = [sys.executable, "-m", "gidl", "gen", *words, TREE / "tests/idl/open/barograph.gidl"]
    subprocess.run(made, check=True, stdout=subprocess.DEVNULL)
    return out / "lcm" / "barograph.lcm"


@pytest.fixture(scope="module")
def stock_python(lcm_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The class that lcm-gen makes of the type."""
    out = tmp_path_factory.mktemp("lcm_python")
    subprocess.run([of_wheel("bin/lcm-gen"), "-p", "--ppath", out, lcm_file], check=True)
    sys.path.insert(0, str(out))
    from weather import Reading as StockReading  # type: ignore[import-not-found]

    yield StockReading
    sys.path.remove(str(out))


@pytest.fixture
def name() -> str:
    """An object of this test alone: all programs of the host meet at the port of LCM."""
    return f"BARO{secrets.token_hex(4)}"


def start_server(lab: Laboratory, language: str, name: str) -> Program:
    if language == "C++":
        server: list[str | Path] = [lab.build / "tests" / "system" / "open" / "open_server"]
    else:
        server = [sys.executable, HERE / "server.py"]
    return lab.start(*server, name, ready="serving")


def logged(log: Path, name: str) -> list[bytes]:
    """The messages of the open stream in a log, which may still be growing."""
    if not log.exists() or log.stat().st_size == 0:
        return []
    channel = f"{name}.readings"
    return [bytes(each.data) for each in EventLog(str(log)) if each.channel == channel]


def record(lab: Laboratory, name: str, log: Path) -> list[Reading]:
    """Has stock lcm-logger record some readings. Returns the same readings as a client got them."""
    lab.env.pop("LCM_DEFAULT_URL", None)
    logger = lab.start(of_wheel("bin/lcm-logger"), "--flush-interval=10", log)
    with gecos.Lab() as mine:
        baro = mine.create(Barograph, name, medium="lcm")

        def heard(first: int, times: int) -> bool:
            baro.record(0, 1, 1).result()  # the logger writes a message to the file with the next
            numbers = [number_of(each) for each in logged(log, name)]
            return len([number for number in numbers if number >= first]) >= times

        until(lambda: heard(0, 1), "lcm-logger hears the stream")
        stream = baro.sealed.stream()
        baro.record(FIRST, TIMES, 3).result()
        came: list[Reading] = []
        while len(came) < TIMES:
            sample = stream.next(PATIENCE_S)
            came.extend([sample.value] if sample.value.number >= FIRST else [])
        until(lambda: heard(FIRST, TIMES), "lcm-logger has all readings")
    logger.terminate()
    return came


def number_of(message: bytes) -> int:
    """The number of the reading, which follows the fingerprint."""
    return int.from_bytes(message[8:12], "big")


def recorded(log: Path, name: str) -> list[bytes]:
    """The messages of the readings from FIRST on."""
    return [each for each in logged(log, name) if number_of(each) >= FIRST]


@pytest.mark.parametrize("server", ["C++", "Python"])
@pytest.mark.usefixtures("here")
def test_stock_logger_records_and_stock_python_decodes_what_was_published(
    server: str, name: str, lab_with_broker: Laboratory, stock_python: Any, tmp_path: Path
) -> None:
    start_server(lab_with_broker, server, name)
    published = record(lab_with_broker, name, tmp_path / "log")
    read = [stock_python.decode(each) for each in recorded(tmp_path / "log", name)]
    assert [each.number for each in read] == list(range(FIRST, FIRST + TIMES))
    for stock, ours in zip(read, published, strict=True):
        assert stock.number == ours.number
        assert (stock.place.name, stock.place.latitude) == (ours.place.name, ours.place.latitude)
        assert stock.place.name == "Königstuhl"
        assert stock.trend == int(ours.trend)
        assert list(stock.pressures) == list(ours.pressures)
        assert [each % 2**16 for each in stock.histogram] == [1, 2, 65535]
        assert stock.remark == ([] if ours.remark is None else [ours.remark])
    assert {len(each.remark) for each in read} == {0, 1}


@pytest.mark.skipif(shutil.which("javac") is None, reason="needs javac (a JDK, 11 or newer)")
@pytest.mark.usefixtures("here")
def test_the_decoder_of_lcm_spy_shows_the_same_values(
    name: str, lab_with_broker: Laboratory, lcm_file: Path, tmp_path: Path
) -> None:
    jar, out = of_wheel("share/java/lcm.jar"), tmp_path / "java"
    subprocess.run([of_wheel("bin/lcm-gen"), "-j", "--jpath", out, lcm_file], check=True)
    sources = [HERE / "Decode.java", *out.rglob("*.java")]
    subprocess.run(["javac", "-encoding", "UTF-8", "-cp", jar, "-d", out, *sources], check=True)
    types = tmp_path / "types.jar"  # lcm-spy looks for types in the jars of CLASSPATH
    subprocess.run(["jar", "cf", types, "-C", out, "weather"], check=True)

    start_server(lab_with_broker, "C++", name)
    published = record(lab_with_broker, name, tmp_path / "log")
    path = os.pathsep.join(map(str, [out, jar, types]))
    shown = subprocess.run(
        ["java", "-cp", path, "Decode", tmp_path / "log", f"{name}.readings"],
        env={**os.environ, "CLASSPATH": path},
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    expected = [
        f"weather.Reading{{number={each.number},"
        f"place={{name={each.place.name},latitude={each.place.latitude}}},"
        f"trend={int(each.trend)},pressures_n={len(each.pressures)},"
        f"pressures=[{','.join(str(float(p)) for p in each.pressures)}],histogram=[1,2,-1],"
        f"remark_n={int(each.remark is not None)},remark=[{each.remark or ''}]}}"
        for each in published
    ]
    # LCMTypeDatabase prints which jars it looks into.
    lines = [each for each in shown.splitlines() if each.startswith("weather.")]
    # The Java of lcm-gen takes the bytes of a string, which are UTF-8, for ISO 8859-1.
    lines = [each.encode("latin-1").decode("utf-8") for each in lines]
    assert [each for each in lines if "{number=0," not in each] == expected


@pytest.mark.usefixtures("here")
def test_only_a_server_that_uses_lcm_publishes_in_clear(
    name: str, lab_with_broker: Laboratory
) -> None:
    """A message that the test sends afterwards arrives, and none of the server before it."""
    lab_with_broker.start(sys.executable, HERE / "server.py", name, "shm", ready="serving")
    with gecos.Lab() as mine:
        baro = mine.create(Barograph, name)
        assert heard_in_clear(name, lambda: baro.record(FIRST, TIMES, 3).result()) == 0


FORBIDDEN = "[streams]\nopen = false\n"


def heard_in_clear(name: str, publish: Callable[[], object]) -> int:
    """Number of messages in clear that `publish` causes. A message that the test sends afterwards
    arrives after them."""
    heard: list[str] = []
    bus = LCM("udpm://239.255.76.67:7667?ttl=0")
    bus.subscribe(f"{name}.*", lambda channel, _: heard.append(channel))
    publish()
    bus.publish(f"{name}.end", b"")
    until(lambda: bool(bus.handle_timeout(1000)) and f"{name}.end" in heard, "the last message")
    return heard.count(f"{name}.readings")


@pytest.mark.parametrize("server", ["C++", "Python"])
@pytest.mark.usefixtures("here")
def test_a_lab_file_forbids_open_streams_and_clients_read_them_as_before(
    server: str, name: str, lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(FORBIDDEN)
    lab_with_broker.env["GECOS_LAB_FILE"] = str(file)
    program = start_server(lab_with_broker, server, name)
    with gecos.Lab() as mine:
        baro = mine.create(Barograph, name, medium="lcm")
        with baro.readings.stream() as stream:
            assert heard_in_clear(name, lambda: baro.record(FIRST, TIMES, 3).result()) == 0
            assert stream.next(PATIENCE_S).value.number >= FIRST
    said = f"[streams] in {file}:2 forbids open streams: {name} sends no sample in clear"
    assert program.output().count(said) == 1, "once for the object"


@pytest.mark.usefixtures("here")
def test_an_edit_of_the_lab_file_forbids_open_streams_and_allows_them_again(
    name: str, lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    file = tmp_path / "lab.toml"
    file.write_text("")
    lab_with_broker.env["GECOS_LAB_FILE"] = str(file)
    program = start_server(lab_with_broker, "Python", name)
    with gecos.Lab() as mine:
        baro = mine.create(Barograph, name, medium="shm")

        def publish() -> None:
            baro.record(FIRST, TIMES, 3).result()

        assert heard_in_clear(name, publish) == TIMES
        file.write_text(FORBIDDEN)
        program.wait_for(f"forbids open streams: {name} sends no sample in clear")
        assert heard_in_clear(name, publish) == 0
        file.write_text("[streams]\nopen = true\n")
        program.wait_for(f"the lab file allows open streams again: {name} may send")
        assert heard_in_clear(name, publish) == TIMES


def test_policy_says_whether_a_stream_is_sent_in_clear(
    name: str, lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    start_server(lab_with_broker, "Python", name)
    file = tmp_path / "lab.toml"
    who = (pwd.getpwuid(os.geteuid()).pw_name, socket.gethostname())

    def told(member: str) -> tuple[str, bool]:
        words = ["policy", "test", *who, name, member, "--file", str(file)]
        command = [sys.executable, "-m", "gecos.cli", *words]
        line = lab_with_broker.run(*command).lines[-1]
        return line, json.loads(lab_with_broker.run(*command, "--json").output())["sent_in_clear"]

    file.write_text("")
    assert told("readings") == (
        "readings is an open stream: over lcm, everybody on the network can read its samples, "
        "whatever the lists say",
        True,
    )
    assert told("sealed") == ("reading sealed needs no status, for every caller", False)
    file.write_text(FORBIDDEN)
    assert told("readings") == (
        f"readings is an open stream, and [streams] in {file}:2 forbids it: no sample is sent in "
        "clear",
        False,
    )


def test_an_object_whose_channel_has_too_long_a_name_is_served_without_it(
    lab_with_broker: Laboratory,
) -> None:
    name = "B" * 60
    server = lab_with_broker.start(sys.executable, HERE / "server.py", name, ready="serving")
    assert f"stream 'readings' of {name} is not published in clear over lcm: " in server.output()


@pytest.mark.parametrize("server", ["C++", "Python"])
@pytest.mark.usefixtures("here")
def test_a_sample_that_is_too_large_for_a_message_is_dropped_with_a_line_in_the_log(
    server: str, name: str, lab_with_broker: Laboratory
) -> None:
    program = start_server(lab_with_broker, server, name)
    with gecos.Lab() as mine:
        baro = mine.create(Barograph, name, medium="shm")
        baro.record(FIRST, 1, 20_000).result()
        counted = {each.stream: each.dropped for each in gecos.stats(baro).result().streams}
    assert counted == {"readings": 1, "sealed": 0}, "over shm nobody subscribes"
    program.wait_for(f"{name}: a sample of 'readings' takes 160")


def test_describe_says_which_streams_are_open(name: str, lab_with_broker: Laboratory) -> None:
    start_server(lab_with_broker, "Python", name)
    said = lab_with_broker.run(sys.executable, "-m", "gecos.cli", "describe", name).lines
    assert "  readings: weather::Reading  (stream out at 10 Hz, open to anybody)" in said
    assert "  sealed: weather::Reading  (stream out at 10 Hz)" in said
