"""Where no packet of lcm can be sent: we say so, once, and LCM says nothing."""

from __future__ import annotations

import os
import sys

import pytest
from processes import Laboratory

NETWORK_OF_ITS_OWN = ("unshare", "-n") if os.geteuid() == 0 else ("unshare", "-Urn")
NO_ROUTE = (
    "lcm: cannot send to 239.255.76.67: Network is unreachable (no multicast route? run as root:"
)

WAITING = """
import gecos
try:
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        server.await_broker(1.5)
except gecos.ServeError as error:
    print("the end:", error)
"""


@pytest.fixture
def over_lcm(lab: Laboratory) -> Laboratory:
    lab.env["GECOS_BROKER"] = "lcm"
    return lab


def test_a_client_says_it_in_one_line(over_lcm: Laboratory) -> None:
    client = over_lcm.run(*NETWORK_OF_ITS_OWN, over_lcm.build / "examples" / "lds_client")
    assert len(client.lines) == 1, client
    assert client.lines[0].startswith("LASER: NO_SERVER: no broker answers;")
    assert NO_ROUTE in client.lines[0]


def test_a_server_that_goes_on_asking_says_it_once(over_lcm: Laboratory) -> None:
    server = over_lcm.run(*NETWORK_OF_ITS_OWN, sys.executable, "-c", WAITING)
    warning, end = server.lines
    assert warning.startswith("gecos warning session: no broker answers;")
    assert "this server goes on asking" in warning
    assert end.startswith("the end: no broker answers;")
    assert NO_ROUTE in warning and NO_ROUTE in end
