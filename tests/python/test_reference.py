"""Objects as values: a reference of a proxy is a proxy again, here and in another process."""

from __future__ import annotations

import dataclasses

import gecos
import pytest
from gecos import wire
from gecos_idl.object_ref_types import ObjectRef
from lamp import Lamp
from test_process import running, says


def test_a_reference_says_which_object_it_is(lamp: Lamp) -> None:
    reference = gecos.reference(lamp)
    assert reference.name == "LAMP"
    assert reference.interface_hash == Lamp._gecos_interface.hash
    assert reference.boot != 0
    assert reference.where.startswith("inproc: ")


def test_it_is_a_proxy_again(lab: gecos.Lab, lamp: Lamp) -> None:
    again = lab.create(Lamp, wire.from_bytes(ObjectRef, wire.to_bytes(gecos.reference(lamp))))
    assert again.label().result() == lamp.label().result()


def test_nil_is_refused_by_name(lab: gecos.Lab) -> None:
    with pytest.raises(gecos.CreateError, match=r"\(nil\).*an empty name refers to no object"):
        lab.create(Lamp, ObjectRef())


def test_another_life_of_the_server_is_another_object(lab: gecos.Lab, lamp: Lamp) -> None:
    reference = gecos.reference(lamp)
    old = dataclasses.replace(reference, boot=reference.boot ^ 1)
    with pytest.raises(gecos.CreateError, match="the server was restarted"):
        lab.create(Lamp, old)
    assert lab.create(Lamp, ObjectRef(name="LAMP")).label().result()  # whoever did not know


USING = """
import gecos
from gecos.wire import from_bytes
from gecos_idl.object_ref_types import ObjectRef
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, from_bytes(ObjectRef, bytes.fromhex("{}")))
print(lamp.label().result(), flush=True)
"""


def test_another_process_can_use_it(lamp: Lamp, server: gecos.Server) -> None:
    sent = wire.to_bytes(gecos.reference(lamp)).hex()
    with running(USING.format(sent)) as client:
        assert says(client).strip() == lamp.label().result()
