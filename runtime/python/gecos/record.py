"""Immutable values with named members, like those of `@dataclass(frozen=True)`, but with classes
that are made quickly.

    class Stream(Record, kw_only=True):
        name: str
        rate_hz: float = 0.0

A dataclass compiles six methods for each class, which takes a millisecond or two. The tables of
interfaces and models need about twenty classes, and every start of `gecos` makes all of them.
"""

from __future__ import annotations

from typing import Any, ClassVar, TypeVar, dataclass_transform

R = TypeVar("R", bound="Record")


@dataclass_transform(frozen_default=True)
class Record:
    """Base class of values whose members are the annotated names of the class. All values share the
    default of a member, so the default must be immutable. Members in `derived` are computed from
    others: `==` and `repr` leave them out."""

    _members: ClassVar[tuple[str, ...]] = ()
    _defaults: ClassVar[dict[str, Any]] = {}
    _shown: ClassVar[tuple[str, ...]] = ()
    _positional: ClassVar[int] = 0

    def __init_subclass__(
        cls, *, kw_only: bool = False, derived: tuple[str, ...] = (), **words: Any
    ) -> None:
        super().__init_subclass__(**words)
        cls._members = tuple(cls.__annotations__)
        cls._defaults = {name: vars(cls)[name] for name in cls._members if name in vars(cls)}
        cls._shown = tuple(name for name in cls._members if name not in derived)
        cls._positional = 0 if kw_only else len(cls._members)

    def __init__(self, *given: Any, **named: Any) -> None:
        values = dict(zip(self._members, given, strict=False))
        unknown = named.keys() - set(self._members)
        twice = values.keys() & named.keys()
        missing = set(self._members) - self._defaults.keys() - values.keys() - named.keys()
        if len(given) > self._positional or unknown or twice or missing:
            wrong = ", ".join(sorted(unknown | twice | missing)) or f"{len(given)} values"
            raise TypeError(
                f"{type(self).__name__} has the members {', '.join(self._members)}, of which "
                f"{self._positional} may be given without their names; these are wrong: {wrong}"
            )
        self.__dict__.update(self._defaults | values | named)
        self.__post_init__()

    def __post_init__(self) -> None:
        """Runs at the end of the constructor. A subclass may override this method to compute
        further members, and stores them in `self.__dict__` because the instance is immutable."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable: {name} cannot be set")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self is other or self._values() == other._values()

    def __hash__(self) -> int:
        return hash(self._values())

    def __repr__(self) -> str:
        shown = zip(self._shown, self._values(), strict=True)
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in shown)})"

    def _values(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in self._shown)


def replace(record: R, **changes: Any) -> R:
    """Returns a copy of `record` in which the named members have other values."""
    members = {name: getattr(record, name) for name in record._members}
    return type(record)(**members | changes)
