"""Samples that are RELIABLE in the interface, over each medium, for both kinds of clients."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gecos
import pytest
from generated_module import imported

CORNERS = Path(__file__).resolve().parents[1] / "idl" / "corners"


@pytest.fixture(scope="module")
def reliable(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The generated module of reliable.gidl."""
    out = tmp_path_factory.mktemp("reliable")
    with imported("reliable", CORNERS / "reliable.gidl", CORNERS, out) as module:
        yield module


@pytest.fixture
def served(lab: gecos.Lab, reliable: Any) -> Iterator[None]:
    class Tank(reliable.TankServant):  # type: ignore[misc]
        def capacity(self) -> float:
            return 3.0

        def content(self) -> float:
            return 2.0

        def level(self) -> float:
            return 0.5

        def height(self) -> float:
            return 1.0

        def set_height(self, value: float) -> None: ...

    with gecos.Server(lab) as server:
        server.add("TANK", Tank(), simulated=True)
        yield


Client = Callable[[str], Any]


@pytest.fixture(params=["generated", "dynamic"])
def client(request: pytest.FixtureRequest, lab: gecos.Lab, served: None, reliable: Any) -> Client:
    def connected(medium: str) -> Any:
        if request.param == "generated":
            return lab.create(reliable.Tank, "TANK", medium=medium)
        return lab.dynamic("TANK", medium=medium)

    return connected


OPENED: dict[str, Callable[[Any], Any]] = {
    "level": lambda tank: tank.level.stream(),
    "height": lambda tank: tank.height.stream(),
    "flow": lambda tank: tank.flow.writer(),
    "emptied": lambda tank: tank.emptied.stream(),
    "filled": lambda tank: tank.filled.stream(),
}
RELIABLE = ("height", "flow", "emptied")


@pytest.mark.parametrize("medium", ["inproc", "shm"])
def test_over_memory_all_streams_open(client: Client, medium: str) -> None:
    tank = client(medium)
    for opened in OPENED.values():
        opened(tank).close()


def test_over_lcm_those_that_are_reliable_are_refused_and_every_call_works(
    client: Client,
) -> None:
    tank = client("lcm")
    for name, opened in OPENED.items():
        if name not in RELIABLE:
            opened(tank).close()
            continue
        with pytest.raises(gecos.ConnectionFailed) as refused:
            opened(tank)
        assert str(refused.value).startswith("QOS_UNAVAILABLE: "), name
        assert str(refused.value).endswith(
            f"'{name}' of TANK was not opened over lcm: reliability=RELIABLE: the medium lcm may "
            "lose samples, and nothing retransmits them; create the proxy over another medium"
        )
    assert [tank.capacity().result(), tank.content().result()] == [3.0, 2.0]
    assert [tank.level().result(), tank.height().result()] == [0.5, 1.0]
    with gecos.actor(tank):
        tank.set_height(2.0).result()


@pytest.mark.usefixtures("served")
def test_explain_names_the_samples_that_have_a_getter_apart(lab: gecos.Lab, reliable: Any) -> None:
    told = lab.explain(reliable.Tank, "TANK")
    over_lcm = next(each for each in told.media if each.medium == "lcm")
    assert {each.what for each in over_lcm.members} == {
        "the samples of height",
        "flow",
        "emptied",
    }
