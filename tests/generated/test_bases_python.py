"""Interfaces may derive from each other in any order that IDL allows."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module
from itertools import permutations
from random import Random
from typing import Any

import pytest
from generating import generate


def file(dice: Random) -> str:
    lines = ["#pragma once", "module bases {"]
    for i, order in enumerate(permutations(("Left", "Right", "Near"))):
        if not i:
            lines.append("  interface Left { void l(); };  interface Right { void r(); };")
            lines.append("  interface Near : Left { void n(); };")
        lines.append(f"  interface Some{i} : {', '.join(order)} {{ void own{i}(); }};")
    lines.append(f"  interface All : {', '.join(f'Some{i}' for i in range(6))} {{}};")
    known = ["Left", "Right", "Near", "All"]
    for i in range(40):
        bases = dice.sample(known, min(len(known), dice.randint(1, 4)))
        lines.append(f"  interface Any{i} : {', '.join(bases)} {{ void run{i}(); }};")
        known.append(f"Any{i}")
    return "\n".join([*lines, "};", ""])


@pytest.fixture(scope="module")
def module(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    out = tmp_path_factory.mktemp("bases")
    (out / "bases.gidl").write_text(file(Random(7)))
    generate(out, out / "bases.gidl")
    sys.path.insert(0, str(out / "python"))
    yield import_module("bases")
    sys.path.remove(str(out / "python"))


def test_proxies_and_servants_have_all_that_they_inherit(module: Any) -> None:
    for i in range(6):
        proxy, servant = getattr(module, f"Some{i}"), getattr(module, f"Some{i}Servant")
        for kind in (proxy, servant):
            assert all(hasattr(kind, name) for name in ("l", "r", "n", f"own{i}"))
        assert issubclass(module.All, proxy)
        assert issubclass(module.AllServant, servant)
    assert len(module.AllServant._gecos_handlers) == 9
    assert len(module.All._gecos_interface.operations) == 9


def test_each_class_derives_from_the_bases_of_its_interface(module: Any) -> None:
    for name in module.__all__:
        interface = getattr(module, name)._gecos_interface
        classes = {kind._gecos_interface.name for kind in getattr(module, name).__mro__[:-1]
                   if hasattr(kind, "_gecos_interface")}  # fmt: skip
        assert classes - {"gecos::Object"} == {interface.name, *interface.bases}
