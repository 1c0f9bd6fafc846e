"""The layout of unions: which arm a tag selects, and how tag and arm are encoded and decoded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, char, number
from gecos.wire.errors import HIDDEN, DecodeProblem, EncodeError, JsonError
from gecos.wire.kinds import (
    Char,
    Enumerators,
    Flags,
    Kind,
    Nested,
    Number,
    Secret,
    Text,
    below,
    expect_json,
    limits_of,
)
from gecos.wire.values import same

NOT_OF_TAG = (
    "the value does not agree with the union's discriminator; make it with one of the functions "
    "make_…"
)
CONTAINERS = (bytes, bytearray, list, tuple, dict)
WITHOUT_ITEMS = (Number, Char, Text, Enumerators, Flags, Nested)


class Arm:
    """An arm of a union. An arm without `tags` is selected by every tag that selects no other
    arm."""

    __slots__ = ("kind", "name", "tags")

    def __init__(self, name: str, kind: Kind, tags: Sequence[Any]) -> None:
        self.name = name
        self.kind = kind
        self.tags = tags


class _Tag:
    """A tag that is not an enum: a whole number, boolean or character, in 4 or 8 bytes."""

    __slots__ = ("_char", "_code", "_wire", "least")

    def __init__(self, kind: Kind) -> None:
        assert isinstance(kind, Number | Char)
        self._char = isinstance(kind, Char)
        self._code = "B" if isinstance(kind, Char) else kind.code
        self._wire = "Q" if self._code == "Q" else "q" if self._code in "Iq" else "i"
        self.least = 4 if self._wire == "i" else 8

    def put(self, tag: Any, out: Parts, label: str) -> None:
        if self._char:
            tag = char(tag)[0]
        elif self._code == "?":
            tag = int(tag)
        out.append(number(tag, self._wire, label))

    def take(self, source: Decoder, label: str) -> Any:
        read: int = source.number(self._wire, label)
        low, high = (0, 1) if self._code == "?" else limits_of(self._code)
        if not low <= read <= high:
            source.refuse(DecodeProblem.UNKNOWN_UNION_TAG, label, source.offset - self.least)
        return chr(read) if self._char else read == 1 if self._code == "?" else read


class UnionLayout:
    """The layout of a union. The union is a dataclass with `tag` and `value`; see
    `gecos.wire.layout.union`."""

    __slots__ = (
        "_deep", "_keeps_secrets", "_otherwise", "_selected", "_tag", "arms", "fingerprint",
        "in_block", "kind", "label", "open", "tag",
    )  # fmt: skip
    compiled = False

    def __init__(
        self,
        kind: Any,
        fingerprint: int,
        tag: Kind,
        arms: Sequence[Arm],
        open: bool,
        deep: bool,
        label: str,
    ) -> None:
        self.kind = kind
        self.fingerprint = fingerprint
        self.tag = tag
        self.arms = arms
        self.open = open
        self.in_block = open
        self.label = label or kind.__name__
        self._deep = deep
        self._keeps_secrets = self.has_secrets
        self._tag: Any = _Tag(tag) if isinstance(tag, Number | Char) else tag
        self._selected = {each: i for i, arm in enumerate(arms, start=1) for each in arm.tags}
        self._otherwise = next((i for i, arm in enumerate(arms, start=1) if not arm.tags), 0)

    def selected(self, tag: Any) -> int:
        """Returns the number of the arm that `tag` selects, counted from 1; 0 if `tag` selects no
        arm."""
        try:
            return self._selected.get(tag, self._otherwise)
        except TypeError:  # an unhashable value is not a tag
            return self._otherwise

    @property
    def least(self) -> int:
        return self._tag.least + len(self.arms)  # type: ignore[no-any-return]

    @property
    def holds_array(self) -> bool:
        return any(arm.kind.holds_array for arm in self.arms)

    @property
    def has_secrets(self) -> bool:
        return any(isinstance(arm.kind, Secret) for arm in self.arms)

    def encode(self, union: Any, out: Parts) -> None:
        selected = self.selected(union.tag)
        value = union.value
        if (value is None) != (selected == 0):
            raise EncodeError(self.label, NOT_OF_TAG)
        self._tag.put(union.tag, out, f"{self.label}.tag")
        for i, arm in enumerate(self.arms, start=1):
            out.append(b"\1" if i == selected else b"\0")
            if i == selected:
                kind = Secret(arm.kind) if self._may_be_secret(arm.kind, value) else arm.kind
                kind.put(value, out, f"{self.label}.{arm.name}")

    def decode(self, kind: Any, source: Decoder) -> Any:
        if self._deep:
            source.enter(self.label)
        tag = self._tag.take(source, f"{self.label}.tag")
        selected = self.selected(tag)
        value: Any = None
        for i, arm in enumerate(self.arms, start=1):
            label = f"{self.label}.{arm.name}"
            if source.arm(i == selected, label):
                value = arm.kind.take(source, label)
        if self.open:
            source.offset = source.end
        if self._deep:
            source.leave()
        return kind(tag, value)

    def plain(self, union: Any) -> Any:
        """Returns {"tag": …, "value": …}, without "value" if the tag selects no arm."""
        arm, tag = self.selected(union.tag), self.tag.plain(union.tag)
        if not arm:
            return {"tag": tag}
        return {"tag": tag, "value": self.arms[arm - 1].kind.plain(union.value)}

    def made(self, data: Any, path: str) -> Any:
        expect_json(dict, data, path, "an object")
        if "tag" not in data:
            raise JsonError(path, "the union's discriminator is missing: tag")
        tag = self.tag.made(data["tag"], below(path, "tag"))
        arm = self.selected(tag)
        for name in sorted(data):
            if name != "tag" and not (arm and name == "value"):
                raise JsonError(
                    below(path, name),
                    "the tag of this union allows no member of this name",
                )
        if not arm:
            return self.kind(tag)
        if "value" not in data:
            raise JsonError(
                path,
                "the member 'value' is missing: the tag of this union selects an arm, and each "
                "arm has a value",
            )
        return self.kind(tag, self.arms[arm - 1].kind.made(data["value"], below(path, "value")))

    def printing(self) -> Callable[[Any], str]:
        """Returns a `__repr__` that hides secrets."""

        def __repr__(union: Any) -> str:
            return self._shown(union)

        return __repr__

    def _may_be_secret(self, kind: Kind | None, value: Any) -> bool:
        """Returns whether `value` may be secret, in a union that has secret arms. `kind` is the
        kind of the selected arm, or None. If the selected arm is secret, `value` is secret. A text
        or container that does not fit the selected arm counts as secret, too, because it may belong
        to a secret arm."""
        if not self._keeps_secrets or isinstance(kind, Secret):
            return self._keeps_secrets
        if isinstance(value, str):
            return not (isinstance(kind, Text) and _fits(kind, value))
        return isinstance(value, CONTAINERS) and (kind is None or isinstance(kind, WITHOUT_ITEMS))

    def _shown(self, union: Any) -> str:
        arm = self.selected(union.tag)
        kind = self.arms[arm - 1].kind if arm else None
        value = HIDDEN if self._may_be_secret(kind, union.value) else repr(union.value)
        return f"{type(union).__name__}(tag={union.tag!r}, value={value})"

    def equality(self) -> Callable[[Any, object], bool]:
        """Returns an `__eq__` for values that hold arrays."""
        kind = self.kind

        def __eq__(self: Any, other: object) -> bool:
            if not isinstance(other, kind):
                return NotImplemented
            return bool(self.tag == other.tag) and same(self.value, other.value)

        return __eq__


def _fits(kind: Text, text: str) -> bool:
    try:
        kind.put(text, [], "")
    except EncodeError:
        return False
    return True
