"""A struct in wire order: runs of numbers, and everything else one by one."""

from __future__ import annotations

from dataclasses import dataclass

from gidl.languages import PYTHON_WORDS
from gidl.model import Member, Struct
from gidl.targets.groups import call, group
from gidl.targets.naming import LocalNames
from gidl.targets.python import names
from gidl.targets.python.lower import Leaf, Lowering, Run, Slot
from gidl.targets.python.values.names import LOCAL_WORDS, may_be_missing
from gidl.targets.python.values.views import RunView
from gidl.type_names import escaped
from gidl.wire_nodes import ScalarNode


@dataclass(frozen=True, slots=True)
class Class:
    """A struct and what its class is called; its members with their places on the wire."""

    struct: Struct
    name: str
    members: tuple[Member, ...]
    attributes: tuple[str, ...]  # what the members are called
    slots: tuple[Slot, ...]


class Plan:
    """A struct's members in wire order: runs of numbers, and everything else one by one."""

    def __init__(self, lowering: Lowering, constants: names.Constants, printed: Class) -> None:
        self._lowering = lowering
        self._class = printed
        self._required = len(printed.members)
        if printed.struct.is_appendable:
            while self._required and may_be_missing(printed.members[self._required - 1]):
                self._required -= 1
        # Groups: member indices that share a run, or a single index without one.
        self._groups: list[tuple[Run | None, list[int]]] = []
        for i, slot in enumerate(printed.slots):
            leaves = lowering.leaves(slot) if i < self._required else None
            if leaves is None:
                self._groups.append((None, [i]))
            elif self._groups and self._groups[-1][0] is not None:
                last, indices = self._groups[-1]
                assert last is not None
                last.leaves += leaves
                indices.append(i)
            else:
                self._groups.append((Run(leaves), [i]))
        runs = [run for run, _ in self._groups if run is not None]
        self._names = {
            id(run): constants.name(printed.name, "layout")
            if len(runs) == 1
            else constants.name(printed.name, "layout", str(n))
            for n, run in enumerate(runs, start=1)
        }

    @property
    def missing(self) -> int:
        """How many of the last members an older writer may leave out."""
        return len(self._class.members) - self._required

    def run_views(self) -> list[RunView]:
        return [
            RunView(
                self._names[id(run)],
                "".join(leaf.code for leaf in run.leaves),
                tuple(leaf.label for leaf in run.leaves),
            )
            for run, _ in self._groups
            if run is not None
        ]

    def encode_body(self) -> list[str]:
        lines: list[str] = []
        local = self._locals()
        for run, indices in self._groups:
            if run is None:
                lines += self._lowering.encode(self._class.slots[indices[0]], local)
                continue
            for i in indices:
                lines += self._lowering.expected(self._class.slots[i])
            packed = call(f"{self._names[id(run)]}.pack", *(leaf.access for leaf in run.leaves))
            lines.append(call("out.append", packed))
            for leaf in run.leaves:
                lines += self._lowering.check_leaf(leaf)
        return lines or ["pass"]

    def decode_body(self, recursive: bool) -> list[str]:
        struct = self._class.struct
        only = self._groups[0][0] if len(self._groups) == 1 else None
        if only is not None and self._is_plain(only) and not struct.is_appendable:
            return [f"return cls(*{self._names[id(only)]}.unpack(source))"]
        lines: list[str] = []
        local = self._locals()
        arguments: list[str] = []
        for run, indices in self._groups:
            if run is None:
                lines += self._decode_single(indices[0], local, arguments)
            else:
                lines += self._decode_run(run, indices, local, arguments)
        if recursive:
            lines.insert(0, f'source.enter("{struct.simple_name}")')
            lines.append("source.leave()")
        if struct.is_appendable:
            lines.append("source.offset = source.end  # what a newer writer added is skipped")
        return [*lines, f"return {call('cls', *arguments)}"]

    def _locals(self) -> LocalNames:
        used = {home.name for s in self._class.slots for home in self._lowering.used(s.node)}
        return LocalNames(LOCAL_WORDS | used)

    def _is_plain(self, run: Run) -> bool:
        """Whether what is unpacked are the members as they are."""
        return len(run.leaves) == len(self._class.slots) and all(
            isinstance(slot.node, ScalarNode) and slot.node.bounds is None
            for slot in self._class.slots
        )

    def _decode_single(self, index: int, local: LocalNames, arguments: list[str]) -> list[str]:
        member, slot = self._class.members[index], self._class.slots[index]
        variable = local.fresh(self._class.attributes[index])
        arguments.append(variable)
        text = self._lowering.decode(slot)
        if index < self._required:
            return [f"{variable} = {text}"]
        missing, made = self._lowering.initial(member, slot.node)
        assert not made, "only constants and None stand in for what is missing"
        return [
            f"{variable}: {self._lowering.hint(slot.node)} = {missing}",
            "if source.offset < source.end:",
            f"    {variable} = {text}",
        ]

    def _decode_run(
        self, run: Run, indices: list[int], local: LocalNames, arguments: list[str]
    ) -> list[str]:
        variables = [local.fresh(_variable(leaf)) for leaf in run.leaves]
        unpacked = f"{self._names[id(run)]}.unpack(source)"
        left = ", ".join(variables)
        if len(variables) == 1:
            left = f"({left},)"
        elif len(left) + len(unpacked) > 88:
            left = group(variables)
        lines = [f"{left} = {unpacked}"]
        for i, (leaf, variable) in enumerate(zip(run.leaves, variables, strict=True)):
            lines += self._lowering.refuse_leaf(leaf, variable, run.behind(i))
        left_over, behind = list(variables), [run.behind(i) for i in range(len(run.leaves))]
        for index in indices:
            slot = self._class.slots[index]
            text = self._lowering.rebuilt(slot.node, left_over, behind, slot.label)
            if text in variables:
                arguments.append(text)
                continue
            made = local.fresh(f"{self._class.attributes[index]}_value")
            lines.append(f"{made} = {text}")
            arguments.append(made)
        return lines


def _variable(leaf: Leaf) -> str:
    """ "self.position.x" -> "position_x"."""
    return escaped(leaf.access.removeprefix("self.").replace(".", "_"), PYTHON_WORDS)
