"""A struct in wire order: runs of numbers, and everything else one by one."""

from __future__ import annotations

from gidl.languages import PYTHON_WORDS
from gidl.model import (
    Member,
    Struct,
)
from gidl.targets.naming import LocalNames
from gidl.targets.python import names
from gidl.targets.python.lower import Leaf, Lowering, Run, Slot
from gidl.targets.python.values.names import (
    LOCAL_WORDS,
    may_be_missing,
    type_names,
)
from gidl.targets.python.values.views import (
    RunView,
)
from gidl.type_names import escaped
from gidl.wire_layout import node_of
from gidl.wire_nodes import ScalarNode


class Plan:
    """A struct's members in wire order: runs of numbers, and everything else one by one."""

    def __init__(
        self,
        lowering: Lowering,
        constants: names.Constants,
        struct: Struct,
        members: tuple[Member, ...],
        slots: list[Slot],
        name: str,
        words: frozenset[str],
    ) -> None:
        self._lowering = lowering
        self._struct = struct
        self._members = members
        self._slots = slots
        self._words = words
        self._required = len(members)
        if struct.is_appendable:
            while self._required and may_be_missing(members[self._required - 1]):
                self._required -= 1
        # Groups: member indices that share a run, or a single index without one.
        self._groups: list[tuple[Run | None, list[int]]] = []
        for i, slot in enumerate(slots):
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
            id(run): constants.name(name, "layout")
            if len(runs) == 1
            else constants.name(name, "layout", str(n))
            for n, run in enumerate(runs, start=1)
        }

    @property
    def missing(self) -> int:
        """How many of the last members an older writer may leave out."""
        return len(self._members) - self._required

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
                lines += self._lowering.encode(self._slots[indices[0]], local)
                continue
            for i in indices:
                lines += self._lowering.expected(self._slots[i])
            values = ", ".join(leaf.access for leaf in run.leaves)
            lines.append(f"out.append({self._names[id(run)]}.pack({values}))")
            for leaf in run.leaves:
                lines += self._lowering.check_leaf(leaf)
        return lines or ["pass"]

    def decode_body(self, recursive: bool) -> list[str]:
        only = self._groups[0][0] if len(self._groups) == 1 else None
        if only is not None and self._is_plain(only) and not self._struct.is_appendable:
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
            lines.insert(0, f'source.enter("{self._struct.simple_name}")')
            lines.append("source.leave()")
        if self._struct.is_appendable:
            lines.append("source.offset = source.end  # what a newer writer added is skipped")
        return [*lines, f"return cls({', '.join(arguments)})"]

    def _locals(self) -> LocalNames:
        return LocalNames(LOCAL_WORDS | type_names(self._lowering, [m.type for m in self._members]))

    def _is_plain(self, run: Run) -> bool:
        """Whether what is unpacked are the members as they are."""
        return len(run.leaves) == len(self._members) and all(
            isinstance(node_of(self._lowering.model, m.type), ScalarNode)
            and not self._lowering.refuse_leaf(leaf, "x", 0)
            for m, leaf in zip(self._members, run.leaves, strict=True)
        )

    def _decode_single(self, index: int, local: LocalNames, arguments: list[str]) -> list[str]:
        member, slot = self._members[index], self._slots[index]
        variable = local.fresh(names.member_name(member.name, self._words))
        arguments.append(variable)
        text = self._lowering.decode(slot)
        if index < self._required:
            return [f"{variable} = {text}"]
        missing, made = self._lowering.initial(member)
        hint = self._lowering.hint(member.type, member.optional)
        assert not made, "only constants and None stand in for what is missing"
        return [
            f"{variable}: {hint} = {missing}",
            "if source.offset < source.end:",
            f"    {variable} = {text}",
        ]

    def _decode_run(
        self, run: Run, indices: list[int], local: LocalNames, arguments: list[str]
    ) -> list[str]:
        variables = [local.fresh(_variable(leaf)) for leaf in run.leaves]
        left = ", ".join(variables) + ("," if len(variables) == 1 else "")
        unpacked = f"{self._names[id(run)]}.unpack(source)"
        long = len(left) + len(unpacked) > 88
        lines = [
            f"({left}) = {unpacked}" if long or len(variables) == 1 else f"{left} = {unpacked}"
        ]
        for i, (leaf, variable) in enumerate(zip(run.leaves, variables, strict=True)):
            lines += self._lowering.refuse_leaf(leaf, variable, run.behind(i))
        left_over, behind = list(variables), [run.behind(i) for i in range(len(run.leaves))]
        for index in indices:
            member, slot = self._members[index], self._slots[index]
            text = self._lowering.rebuilt(member.type, left_over, behind, slot.label)
            if text in variables:
                arguments.append(text)
                continue
            made = local.fresh(f"{names.member_name(member.name, self._words)}_value")
            lines.append(f"{made} = {text}")
            arguments.append(made)
        return lines


def _variable(leaf: Leaf) -> str:
    """ "self.position.x" -> "position_x"."""
    return escaped(leaf.access.removeprefix("self.").replace(".", "_"), PYTHON_WORDS)
