"""Programs with too few descriptors end with a text and a status, and never say that they serve."""

from __future__ import annotations

import sys

import pytest
from processes import Laboratory, Program

SERVING = """
import gecos
from gecos_idl.broker import BrokerServant
class Nothing(BrokerServant):
    def enlist(self, what, served_for, admitted, confirmed_ago): pass
    def withdraw(self, name): pass
    def lookup(self, name): pass
    def list(self): return []
    def silent(self): return []
    def query(self, interface_name): return []
    def changes(self, since): pass
    def revision(self): pass
    def free(self, name): pass
    def revocations(self, applied): pass
    def behind(self, revoked): pass
gecos.serve({"NOTHING": Nothing()}, simulated=True)
"""


def with_descriptors(lab: Laboratory, most: int, *command: object) -> Program:
    words = ["bash", "-c", f'ulimit -n {most}; exec "$@"', "-"]
    return lab.run(*words, *map(str, command))


@pytest.mark.parametrize("most", [4, 6, 10, 16])
def test_a_server_in_cpp(lab_with_broker: Laboratory, most: int) -> None:
    examples = lab_with_broker.build / "examples"
    server = with_descriptors(lab_with_broker, most, examples / "lds_server")
    assert server.finish() == 1, server
    assert "Too many open files" in server.output() and "ulimit -n" in server.output(), server
    assert "ready" not in server.output()


@pytest.mark.parametrize("most", [4, 6])
def test_a_client_in_cpp(lab_with_broker: Laboratory, most: int) -> None:
    examples = lab_with_broker.build / "examples"
    client = with_descriptors(lab_with_broker, most, examples / "lds_client")
    assert client.finish() == 1, client
    assert "Too many open files" in client.output() and "ulimit -n" in client.output(), client


@pytest.mark.parametrize("most", [4, 10, 16])
def test_a_server_in_python(lab_with_broker: Laboratory, most: int) -> None:
    server = with_descriptors(lab_with_broker, most, sys.executable, "-c", SERVING)
    assert server.finish() == 1, server
    assert "Too many open files" in server.lines[-1], server
    assert "serving" not in server.output()
