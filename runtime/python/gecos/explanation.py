"""The media over which `lab.create` would reach an object, and the reasons against the other
media."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Violation(NamedTuple):
    """A term of an `@qos` that a medium does not meet, and the reason."""

    term: str  # for example "media=shm"
    why: str  # for example "lcm is not one of these media"

    def __str__(self) -> str:
        return f"{self.term}: {self.why}"


class UnsuitedMember(NamedTuple):
    """An operation or stream whose own `@qos` a medium does not meet. Over this medium, a call of
    the operation or a subscription to the stream ends at once as QOS_UNAVAILABLE."""

    name: str
    violations: tuple[Violation, ...]
    samples_only: bool = False
    """True if `violations` concern only the samples of a stream. If the medium does not meet the
    quality of the stream's getter either, the getter has an entry of its own."""

    @property
    def reason(self) -> str:
        return "; ".join(map(str, self.violations))

    @property
    def what(self) -> str:
        """For example "move", or "the samples of tool"."""
        return f"the samples of {self.name}" if self.samples_only else self.name


@dataclass(frozen=True, slots=True)
class MediumVerdict:
    """The reasons for and against one medium of an object."""

    medium: str  # for example "shm"
    address: str
    unreachable: str  # why this program cannot reach the object over it; "" if it can
    violations: tuple[Violation, ...]  # terms of the interface's `@qos` that are not met
    members: tuple[UnsuitedMember, ...]  # only if the medium is suitable
    real_time_by: str = ""
    """What the lab file states, if the interface or a member demands HARD_REALTIME and only this
    statement permits it over the medium. For example "[media.lcm] in lab.toml:2 says that lcm is
    real-time"."""

    @property
    def suitable(self) -> bool:
        return not self.unreachable and not self.violations

    @property
    def reason(self) -> str:
        """The reason why the medium is not suitable; "" if it is suitable."""
        return self.unreachable or "; ".join(map(str, self.violations))


@dataclass(frozen=True, slots=True)
class Explanation:
    """The media of an object: the suitable ones first, in the order in which `lab.create` tries
    them."""

    name: str
    interface_name: str  # the interface of the object
    hostname: str
    simulated: bool
    media: tuple[MediumVerdict, ...]

    def __str__(self) -> str:
        simulated = ", simulated" if self.simulated else ""
        lines = [f"{self.name} ({self.interface_name}{simulated}) on {self.hostname}"]
        for i, each in enumerate(self.media):
            chosen = "chosen" if i == 0 else "used if no medium above it answers"
            lines.append(f"  {each.medium}: {each.reason or chosen}")
            if each.real_time_by:
                lines.append(f"    {each.real_time_by}")
            for member in each.members:
                lines.append(f"    not {member.what}: {member.reason}")
        return "\n".join(lines)
